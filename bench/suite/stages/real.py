"""Real sets through `relief run`: how many views stay, how well they fit each other, whether the model is closed. How well views fit is measured
by peers/pair_residuals.py, which shares nothing with relief's registration, for relief, peers, and the poses that came with the set."""

import json

from suite.stages.align import PCL_PLANES, PCL_TUTORIAL, open3d, pcl, pcl_planes, pcl_tutorial
from suite.inputs import multiply
from suite.measure import Failed, run
from suite.real_sets import start_project
from suite.rows import not_installed, row
from suite.system import PYTHON, ROOT_PEERS

IDENTITY = [[1.0 if i == j else 0.0 for j in range(4)] for i in range(4)]


def measure(case, context):
    relief, folder = context.relief, case.folder
    grids = folder / "grids"
    grids.mkdir(parents=True, exist_ok=True)
    run(relief.command("convert", "-q", "--grids", *case.input(), "-o", grids), folder / "grids.log")
    # Files without poses may hold identities.
    given = poses_with(case.truth_poses or grids / "scan.json") if "given" in case.starts else {}
    published = {name: pose for name, pose in given.items() if pose}
    case.reference = write_poses(folder / "published.json", published) if published and not case.single else None
    rows = []
    for kind in case.starts:
        rows += by_start(case, context, grids, kind)
    if case.reference:
        residuals = pair_residuals(case, grids, [("published poses", case.reference)], folder / "published")
        rows.insert(0, row(case, "published poses", None, **residuals["published poses"], views=len(published)))
    return rows


def by_start(case, context, grids, kind):
    """Rows of all methods from one kind of start: relief from every seed, peers from the first."""
    seeds = range(1, 1 + (1 if kind == "given" else min(case.seeds, context.seeds or case.seeds)))
    found, rows, starts = [], [], {}
    for seed in seeds:
        start = case.folder / f"start-{kind}-{seed}"
        starts[seed] = start_project(grids, start, kind, seed, case.off)
        found.append((f"relief, {label(kind)}" + (f", seed {seed}" if len(seeds) > 1 else ""), *by_relief(case, context, starts[seed], start)))
    folder = case.folder / f"start-{kind}-1"
    for name, (program, align) in peers(case, context).items():
        line = f"{name}, {label(kind)}"
        if not program:
            rows.append(not_installed(case, line))
            continue
        found.append((line, *by_peer(case, folder, starts[1], name, align)))
    # Without published poses those of the method that placed most views are the reference.
    placed = sorted(((name, poses) for name, _, _, poses in found if poses), key=lambda pair: -len(poses_with(pair[1])))
    compared = ([("published poses", case.reference)] if case.reference else []) + placed
    residuals = pair_residuals(case, grids, compared, folder / "residuals") if compared else {}
    lines = [row(case, name, cost, **{**figures, **residuals.get(name, {})}) for name, cost, figures, _ in found]
    return lines + rows


def label(kind):
    return {"given": "given poses", "off": "poses off", "none": "no poses"}[kind]


def by_relief(case, context, start, folder):
    """Cost, figures and file of poses."""
    out = folder / "run"
    try:
        cost = context.relief.cost(folder / "run.log", "run", start, "-o", out, "--fresh")
    except Failed as failure:
        return failure, {}, None
    report = json.loads((out / "report.json").read_text()) if (out / "report.json").exists() else {}
    if "align" not in report:
        return cost, {"aligned": 0, "views": len(poses_with(start))}, None
    views = report["align"]["views"]
    poses = {view["name"]: view["world_from_view"] for view in views if view["aligned"]}
    figures = {"aligned": len(poses), "views": len(views)}
    merged = report.get("merge")
    if merged:
        figures.update(closed=merged["watertight"], components=merged["components"], filled=merged.get("filled_area_fraction"))
    return cost, figures, write_poses(folder / "relief.json", poses)


def peers(case, context):
    """name -> (whether it is there, function); none where one view has nothing to be aligned with."""
    if case.single:
        return {}
    chosen = {"Open3D, multiway": (context.programs.has("Open3D"), open3d("multiway")),
              "PCL, point-to-plane ICP along the tree": (PCL_PLANES.exists(), pcl_planes)}
    if case.room:
        chosen["PCL, tutorial of incremental registration"] = (PCL_TUTORIAL.exists(), pcl_tutorial)
    if case.slow_peers:
        chosen["PCL, ICP along the tree"] = (context.programs.has("PCL"), pcl)
    return chosen


class Prepared:
    """What the functions of suite/align.py need of a case."""

    def __init__(self, folder, project):
        self.folder, self.project = folder, project


def by_peer(case, folder, start, name, align):
    clouds = folder / "clouds"
    try:
        if not (clouds / "clouds.json").exists():
            run([PYTHON, ROOT_PEERS / "clouds.py", folder, clouds], folder / "clouds.log")
        cost, motions = align(Prepared(folder, start), clouds)
    except Failed as failure:
        return failure, {}, None
    poses = {view: multiply(motions[view], pose or IDENTITY) for view, pose in poses_with(start).items() if view in motions}
    stem = "".join(letter if letter.isalnum() else "-" for letter in name.lower())
    return cost, {"aligned": len(poses), "views": len(poses)}, write_poses(folder / f"{stem}.json", poses)


def poses_with(path):
    """name -> 4x4 or None of a project."""
    return {view["name"]: view.get("world_from_view") for view in json.loads(path.read_text())["views"]}


def write_poses(path, poses):
    path.write_text(json.dumps({"views": [{"name": name, "world_from_view": pose} for name, pose in poses.items()]}) + "\n")
    return path


def pair_residuals(case, grids, sets, stem):
    """name -> figures of the poses in a file; the first is the reference. A single view has no pairs."""
    if case.single:
        return {}
    report = stem.with_suffix(".json")
    words = [f"{number}={path}" for number, (_, path) in enumerate(sets)]
    run([PYTHON, ROOT_PEERS / "pair_residuals.py", grids, *words, "--json", report], stem.with_suffix(".log"))
    lines = json.loads(report.read_text())["sets"]
    return {name: {"pairs": line["pairs"], "own": line["own"], "common": line["common"]} for (name, _), line in zip(sets, lines)}
