"""What must hold of relief's own results on the quick case: white noise, a closed object. Lengths in sample spacings."""


def bounds_of(line):
    """(what, value, bound) of one row of relief's."""
    stage = line["stage"]
    if stage == "refine":
        return [("depth RMS of refined views", line["depth_rms"], 0.15),
                ("angle of their normals", line["geometry_normals"], 4.0)]
    if stage == "align":
        return [("mean displacement of poses", line["displacement"], 0.1)]
    if stage in ("merge", "chain"):
        found = [("accuracy RMS of the model", line["accuracy"]["rms"], 0.2),
                 ("boundary edges of the model", line["boundary_edges"], 0),
                 ("model not closed", not line["closed"], 0), ("degenerate faces", line["degenerate"], 0)]
        if line.get("admesh") is not None:
            found.append(("model not closed for admesh", not line["admesh"], 0))
        return found
    return []


def violations(results):
    """A sentence for every figure of relief that is out of its bounds, and for every command of relief that failed."""
    found = []
    for line in results["rows"]:
        if line["method"] != "relief":
            continue
        if "failed" in line:
            found.append(f"{line['case']}, {line['stage']}: {line['failed']}")
        else:
            found += [f"{line['case']}, {line['stage']}: {what} is {value:.4g}, more than {bound}"
                      for what, value, bound in bounds_of(line) if not value <= bound]
    return found
