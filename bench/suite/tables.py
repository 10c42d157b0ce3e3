"""The measured rows as Markdown tables."""

def number(value, digits=3):
    if value is None:
        return "-"
    magnitude = f"{abs(value):.{digits}g}"
    return f"{value:.{digits}g}" if "e" not in magnitude else f"{value:.0f}" if abs(value) >= 1 else f"{value:.1e}"


def percent(value):
    return f"{100 * value:.1f} %"


def markdown(header, lines):
    rule = ["---"] * len(header)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in [header, rule, *lines])


def cost_cells(line, rows):
    """Wall time, processor time as a ratio to relief's on the same case in the same run, peak memory."""
    if "cost" not in line:
        return ["", "", ""]
    own = next(other for other in rows if other["case"] == line["case"] and other["method"] == "relief")
    cost = line["cost"]
    ratio = f"{number(cost['processor'] / own['cost']['processor'], 2)}x" if "cost" in own else "-"
    return [f"{number(cost['wall'])} s", ratio, f"{cost['peak_mb']:.0f} MB"]


COST_HEADER = ["time", "processor time", "memory"]


def table(header, rows, cells):
    """One line per row that is not hidden; the case is named where it changes."""
    lines, case = [], None
    for line in rows:
        if line.get("hidden"):
            continue
        start = [line["case"] if line["case"] != case else "", line["method"]]
        case = line["case"]
        if line.get("missing"):
            body = ["not installed"] + [""] * (len(header) + 2)
        elif "failed" in line:
            body = [failure(line["failed"])] + [""] * (len(header) + 2)
        else:
            body = cells(line) + cost_cells(line, rows)
        lines.append(start + body[:len(header) + 3])
    return markdown(["case", "method", *header, *COST_HEADER], lines)


def failure(message):
    """What a table says of a method that gave nothing."""
    return message if message.startswith("not applicable") else "failed: " + message.split("; see")[0].split(": ")[-1]


def refine_table(rows):
    header = ["depth RMS", "inside", "geometry normals", "inside", "against exact samples'", "normal maps"]
    angle = lambda line, key: f"{number(line[key])}°"
    return table(header, rows, lambda line: [
        number(line["depth_rms"]), number(line["depth_inner_rms"]), angle(line, "geometry_normals"),
        angle(line, "geometry_normals_inner"), angle(line, "sampled_normals"), angle(line, "map_normals")])


def fit_table(rows):
    header = ["geometry to measured normals", "geometry to corrected normals"]
    angle = lambda value: "" if value is None else f"{number(value)}°"
    return table(header, rows, lambda line: [angle(line.get("to_measured")), angle(line.get("to_corrected"))])


def align_table(rows):
    header = ["mean displacement", "worst view", "rotation"]
    return table(header, rows, lambda line: [
        number(line["displacement"]), number(line["worst_view"]), f"{number(line['rotation_deg'])}°"])


def surface(line):
    """Closed or not, and what else is wrong with it."""
    faults = [f"closed, genus {line['genus']}"] if line["closed"] and line["components"] == 1 else []
    if line["boundary_edges"]:
        faults.append(f"{line['boundary_edges']} boundary edges")
    if line["non_manifold"]:
        faults.append(f"{line['non_manifold']} non-manifold")
    if line["components"] > 1:
        faults.append(f"{line['components']} pieces")
    if line["degenerate"]:
        faults.append(f"{line['degenerate']} degenerate faces")
    return ", ".join(faults) or "open"


def mesh_cells(line):
    return [number(line["accuracy"]["rms"]), number(line["accuracy"]["median"]), number(line["completeness"]["rms"]),
            percent(line["completeness"]["within"][0]), f"{number(line['completeness']['normals'])}°",
            surface(line), f"{line['vertices'] / 1000:.0f} k"]


MESH_HEADER = ["accuracy RMS", "median", "completeness RMS", "within 0.5", "normals", "surface", "vertices"]


def merge_table(rows):
    return table(MESH_HEADER, rows, mesh_cells)


def chain_table(rows):
    def cells(line):
        poses = line.get("poses")
        return [number(poses["displacement"]) if poses else "", *mesh_cells(line)]
    return table(["poses", *MESH_HEADER], rows, cells)


def sixteen_table(rows):
    header = ["case", "poses", "measured RMS", "completeness RMS", "normals", "normals back", "vertices", "filled", "surface",
              "processor time", "memory"]
    lines = []
    for line in rows:
        start = [line["case"], line["method"].split()[0]]
        if "failed" in line:
            lines.append(start + [failure(line["failed"])] + [""] * (len(header) - 3))
            continue
        lines.append(start + [
            number(line["measured"]["rms"]), number(line["completeness"]["rms"]), f"{number(line['measured']['normals'])}°",
            f"{number(line['completeness']['normals'])}°", f"{line['vertices'] / 1000:.0f} k", percent(line["filled"]),
            surface(line), f"{number(line['cost']['processor'], 2)} s", f"{line['cost']['peak_mb']:.0f} MB"])
    return markdown(header, lines)


def count(line):
    return f"{line['aligned']} of {line['views']}" if "aligned" in line else ""


def model_cells(line):
    if "closed" not in line:
        return ["", "", ""]
    filled = percent(line["filled"]) if line.get("filled") is not None else ""
    return ["closed" if line["closed"] else "open", str(line["components"]), filled]


def real_table(rows):
    header = ["case", "method, start", "views aligned", "pairs", "own", "p90", "common", "model", "components", "filled", "time"]
    lines, case = [], None
    for line in rows:
        start = [line["case"] if line["case"] != case else "", line["method"]]
        case = line["case"]
        if line.get("missing") or "failed" in line:
            body = ["not installed" if line.get("missing") else failure(line["failed"])] + [""] * (len(header) - 3)
        else:
            own, common = line.get("own", {}), line.get("common", {})
            shown = lambda value: "" if value is None else number(value)
            body = [count(line), str(line.get("pairs", "")), shown(own.get("median")), shown(own.get("p90")), shown(common.get("median")),
                    *model_cells(line), f"{number(line['cost']['wall'])} s" if "cost" in line else ""]
        lines.append(start + body)
    return markdown(header, lines)


def hard_table(rows):
    header = ["case", "defect", "views aligned", "before", "depth", "x clean", "bound", "model", "x clean", "bound", "back", "normals",
              "surface", "time"]
    lines, case = [], None
    for line in rows:
        start = [line["case"] if line["case"] != case else "", line["method"]]
        case = line["case"]
        if "failed" in line:
            lines.append(start + [failure(line["failed"])] + [""] * (len(header) - 3))
            continue
        shown = lambda value: "" if value is None else number(value)
        times = lambda key, of: f"{number(line[of][key])}" if key in line[of] else ""
        lines.append(start + [
            count(line), shown(line.get("before")), shown(line.get("depth")), times("depth", "ratio"), times("depth", "bound"),
            shown(line.get("model")), times("model", "ratio"), times("model", "bound"), shown(line.get("back")),
            f"{number(line['model_normals'])}°" if "model_normals" in line else "", model_cells(line)[0], f"{number(line['cost']['wall'])} s"])
    return markdown(header, lines)


TABLES = {"refine": refine_table, "fit": fit_table, "align": align_table, "merge": merge_table, "chain": chain_table,
          "sixteen": sixteen_table, "real": real_table, "hard": hard_table}
