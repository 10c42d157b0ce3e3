"""The whole way from scans to a model: `relief run` against Open3D's multiway registration and Poisson reconstruction."""

from suite.stages import align, merge, refine
from suite.inputs import clouds, moved, start_clouds
from suite.measure import Failed
from suite.rows import not_installed, row

DEPTH = 9


def measure(case, context):
    rows = [by_relief(case, context)]
    name = f"Open3D, multiway, Poisson, depth {DEPTH}"
    if not context.programs.has("Open3D"):
        return rows + [not_installed(case, name)]
    return rows + [by_open3d(case, context, name)]


def by_relief(case, context):
    relief, folder = context.relief, case.folder / "run"
    try:
        cost = relief.cost(case.folder / "run.log", "run", *case.input(), "-o", folder, "--fresh")
    except Failed as failure:
        return row(case, "relief", failure)
    figures = merge.figures_of(case, relief, folder / "model.ply", case.folder / "run-mesh.log")
    figures["admesh"] = merge.closed_by_admesh(relief, folder / "model.ply", context.programs)
    if case.truth_poses:
        figures["poses"] = align.figures_of(case, relief, folder / "scan.json", case.folder / "run-poses.log")
    if case.truth_views:
        figures["views"] = refine.figures_of(case, relief, folder / "scan.json", case.folder / "run-views.log")
    return row(case, "relief", cost, **figures)


def by_open3d(case, context, name):
    relief, model = context.relief, case.folder / "open3d-chain.ply"
    try:
        aligning, motions = align.open3d("multiway")(case, start_clouds(case, relief))
        project = moved(case, relief, motions, "open3d-chain")
        merging = merge.open3d_poisson(DEPTH)(case, clouds(case, relief, project, "open3d-chain"), model)
    except Failed as failure:
        return row(case, name, failure)
    figures = merge.figures_of(case, relief, model, case.folder / "open3d-chain-mesh.log")
    if case.truth_poses:
        figures["poses"] = align.figures_of(case, relief, project, case.folder / "open3d-chain-poses.log")
    return row(case, name, aligning + merging, **figures)
