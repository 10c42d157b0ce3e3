"""Sixteen views, refined and merged at the poses that were found and at the true ones: what the views' noise leaves."""

from suite.cases import poses_of, with_poses
from suite.measure import cheapest
from suite.stages.merge import closed_by_admesh, figures_of
from suite.rows import row


def measure(case, context):
    relief, folder = context.relief, case.folder
    relief.cost(folder / "align.log", "align", *case.input(), "-o", folder / "aligned.json")
    relief.cost(folder / "refine.log", "refine", folder / "aligned.json", "-o", folder / "refined")
    refined = folder / "refined" / "scan.json"
    found = refined.with_name("found-poses.json")
    relief.cost(folder / "align-again.log", "align", refined, "-o", found)
    projects = {"true poses": with_poses(refined, poses_of(case.truth_poses), "true-poses.json"), "found poses": found}
    models = {name: folder / (name.replace(" ", "-") + ".ply") for name in projects}
    costs = cheapest({name: lambda name=name: relief.cost(folder / "merge.log", "merge", projects[name], "-o", models[name])
                      for name in projects}, context.rounds)
    rows = []
    for name, model in models.items():
        figures = {} if isinstance(costs[name], Exception) else {
            **figures_of(case, relief, model, model.with_suffix(".errors.log")),
            "admesh": closed_by_admesh(relief, model, context.programs)}
        rows.append(row(case, name, costs[name], **figures))
    return rows
