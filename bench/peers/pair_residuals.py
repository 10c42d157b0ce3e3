"""How well the views of a set fit each other, by code that shares nothing with relief's registration.

    pair_residuals.py PROJECT_FOLDER NAME=POSES.json ... [--samples N] [--distance D] [--json FILE] [--pairs]

PROJECT_FOLDER holds a project of grid files (`relief convert --grids PROJECT -o FOLDER`). POSES.json is any file that lists views with
`name` and `world_from_view`: a scan.json, a report of `relief align`, a truth.json. A view that a file does not list, or lists with
`"aligned": false`, is not placed there. The first file is the reference.

For every ordered pair of views, N samples of one are brought into the frame of the other; the residual of a sample is its distance from
the plane through its nearest neighbour there. The plane's normal comes from the 20 nearest samples of that view (their covariance),
turned to the sensor. A sample has a partner when the neighbour is at most D spacings away in the plane's direction and 1.5 spacings
along the plane (farther, the sample lies beyond the other view's border), and both normals agree within 45 degrees. A pair of views
counts when a tenth of the samples has partners.

Two figures per file, both over all pairs, in sample spacings (the median over the views of the median
distance of neighbours along rows and columns of the grid):
- *own*: of the samples that have a partner at these poses;
- *common*: of the samples that have a partner at the reference's poses, whatever became of them: their residual at these poses, with D for those
  that lost their partner. A file that pulls views apart cannot improve this figure by losing pairs.
"""

import argparse
import json
import pathlib
import sys

import numpy as np
from clouds import columns, read_grid, shared_direction
from scipy.spatial import cKDTree

NEIGHBOURS = 20
BESIDE = 1.5  # spacings
LEAST_COSINE = np.cos(np.radians(45))
LEAST_SHARE = 0.1
SEED = 1


def grid_spacing(points, places, width, height):
    """Median distance of neighbours along rows and columns."""
    number = np.full(width * height, -1)
    number[places] = np.arange(len(points))
    number = number.reshape(height, width)
    steps = []
    for first, second in ((number[:, :-1], number[:, 1:]), (number[:-1], number[1:])):
        both = (first >= 0) & (second >= 0)
        steps.append(np.linalg.norm(points[first[both]] - points[second[both]], axis=1))
    return float(np.median(np.concatenate(steps)))


class View:
    """One scan in its own frame, with its normals."""

    def __init__(self, folder, entry, shared, samples, random):
        self.name = entry["name"]
        width, height, vertices, places = read_grid(folder / entry["grid"]["file"])
        self.points = columns(vertices, "xyz")
        self.spacing = grid_spacing(self.points, places, width, height)
        self.tree = cKDTree(self.points)
        self.camera = entry.get("camera", {})
        self.direction = self.camera.get("view_direction", None if self.camera else shared)
        chosen = random.permutation(len(self.points))[:samples]
        self.chosen = self.points[np.sort(chosen)]
        self.normals = np.full(self.points.shape, np.nan)
        self.chosen_normals = self.normals_at(np.sort(chosen))

    def to_sensor(self, points):
        """Directions from points towards the sensor; only their sign against a normal matters."""
        if self.direction is not None:
            return np.broadcast_to(-np.array(self.direction, float), points.shape)
        return -points

    def normals_at(self, indices):
        """Normals of samples by number; worked out when they are asked for, and kept."""
        missing = np.unique(indices[np.isnan(self.normals[indices, 0])])
        for part in np.array_split(missing, len(missing) // 20000 + 1):
            if len(part) == 0:
                continue
            _, near = self.tree.query(self.points[part], k=min(NEIGHBOURS, len(self.points)))
            local = self.points[near] - self.points[near].mean(axis=1, keepdims=True)
            _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
            normals = axes[:, :, 0]
            turned = np.einsum("ni,ni->n", normals, self.to_sensor(self.points[part])) < 0
            normals[turned] *= -1
            self.normals[part] = normals
        return self.normals[indices]


def against(source, target, target_from_source, distance):
    """Residuals of the chosen samples of `source` against `target`, and which of them have a partner there."""
    turn, shift = target_from_source[:3, :3], target_from_source[:3, 3]
    points = source.chosen @ turn.T + shift
    # No partner is farther than this: the search may stop there.
    reach = np.hypot(distance, BESIDE * target.spacing)
    _, nearest = target.tree.query(points, distance_upper_bound=reach)
    found = nearest < len(target.points)
    residuals, partner = np.full(len(points), distance), np.zeros(len(points), bool)
    if not found.any():
        return residuals, partner
    normals = target.normals_at(nearest[found])
    offset = points[found] - target.points[nearest[found]]
    across = np.abs(np.einsum("ni,ni->n", offset, normals))
    along = np.linalg.norm(offset - np.einsum("ni,ni->n", offset, normals)[:, None] * normals, axis=1)
    agree = np.einsum("ni,ni->n", source.chosen_normals[found] @ turn.T, normals) > LEAST_COSINE
    good = (across <= distance) & (along <= BESIDE * target.spacing) & agree
    places = np.flatnonzero(found)
    residuals[places[good]] = across[good]
    partner[places[good]] = True
    return residuals, partner


def read_poses(path):
    """name -> 4x4 of the views that are placed."""
    document = json.loads(path.read_text())
    document = document.get("align", document)
    return {view["name"]: np.array(view["world_from_view"], float) for view in document["views"]
            if view.get("world_from_view") and view.get("aligned", True)}


def all_pairs(views, poses, distance):
    """(source, target) -> residuals and partners, of every ordered pair of placed views."""
    placed = [view for view in views if view.name in poses]
    return {(a.name, b.name): against(a, b, np.linalg.inv(poses[b.name]) @ poses[a.name], distance)
            for a in placed for b in placed if a is not b}


def overlapping(pairs):
    return {key for key, (_, partner) in pairs.items() if partner.mean() >= LEAST_SHARE}


def statistics(parts, spacing):
    if not parts:
        return {"median": None, "p90": None, "samples": 0}
    values = np.concatenate(parts) / spacing
    return {"median": float(np.median(values)), "p90": float(np.percentile(values, 90)), "samples": len(values)}


def figures(pairs, reference, chosen, distance, spacing):
    """`pairs` as all_pairs gives them, of one file; `chosen` are the overlapping pairs of the reference."""
    own = overlapping(pairs)
    common = []
    for key in sorted(chosen):
        partner = reference[key][1]
        residuals = pairs[key][0] if key in pairs else np.full(len(partner), distance)
        common.append(residuals[partner])
    return {"pairs": len({frozenset(key) for key in own}),
            "own": statistics([pairs[key][0][pairs[key][1]] for key in sorted(own)], spacing),
            "common": statistics(common, spacing)}


def pair_list(pairs, spacing):
    return [{"a": a, "b": b, "share": float(pairs[a, b][1].mean()),
             "median": float(np.median(pairs[a, b][0][pairs[a, b][1]]) / spacing)} for a, b in sorted(overlapping(pairs))]


def arguments():
    parser = argparse.ArgumentParser(description="Residuals of all overlapping pairs of views.")
    parser.add_argument("project", type=pathlib.Path, help="folder of a project of grid files")
    parser.add_argument("poses", nargs="+", metavar="NAME=FILE", help="poses to be compared; the first is the reference")
    parser.add_argument("--samples", type=int, default=10000, help="samples of every view (default: 10000)")
    parser.add_argument("--distance", type=float, default=5.0, help="of partners at most [spacings] (default: 5)")
    parser.add_argument("--json", type=pathlib.Path, help="figures for programs")
    parser.add_argument("--pairs", action="store_true", help="with the figures of every pair in the JSON")
    options = parser.parse_args()
    for word in options.poses:
        if "=" not in word:
            parser.error(f"{word}: poses are given as NAME=FILE")
    return options


def measure(options):
    document = json.loads((options.project / "scan.json").read_text())
    random = np.random.default_rng(SEED)
    shared = shared_direction(document)
    views = [View(options.project, entry, shared, options.samples, random) for entry in document["views"]]
    spacing = float(np.median([view.spacing for view in views]))
    distance = options.distance * spacing
    report, reference, chosen = {"views": len(views), "spacing": spacing, "sets": []}, None, None
    for word in options.poses:
        name, path = word.split("=", 1)
        poses = read_poses(pathlib.Path(path))
        pairs = all_pairs(views, poses, distance)
        if reference is None:
            reference, chosen = pairs, overlapping(pairs)
        line = {"name": name, "placed": sum(view.name in poses for view in views),
                **figures(pairs, reference, chosen, distance, spacing)}
        if options.pairs:
            line["pair_list"] = pair_list(pairs, spacing)
        report["sets"].append(line)
    return report


def table(report):
    show = lambda value: "-" if value is None else f"{value:.4f}"
    lines = [f"{report['views']} views, spacing {report['spacing']:.4g}; residuals in spacings",
             f"{'poses':24} {'placed':>6} {'pairs':>5} {'own median':>10} {'p90':>8} {'common median':>13} {'p90':>8}"]
    for line in report["sets"]:
        lines.append(f"{line['name']:24} {line['placed']:6} {line['pairs']:5} {show(line['own']['median']):>10} "
                     f"{show(line['own']['p90']):>8} {show(line['common']['median']):>13} {show(line['common']['p90']):>8}")
    return "\n".join(lines)


if __name__ == "__main__":
    given = arguments()
    result = measure(given)
    if given.json:
        given.json.write_text(json.dumps(result, indent=1) + "\n")
    print(table(result))
    sys.exit(0)
