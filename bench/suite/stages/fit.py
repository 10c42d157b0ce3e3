"""Real measured normals, where no truth is known: how well the geometry comes to agree with them."""

from suite.measure import cheapest
from suite.stages.refine import PUBLISHED
from suite.rows import row


def median_angle(relief, case, project, truth, log):
    """Median angle between the normals of the geometry of `project` and the normal maps of `truth`."""
    report = relief.figures(log, "evaluate", project, *case.options, "--truth", truth)
    return report["geometry_normals_deg"]["median"]


def measure(case, context):
    relief = context.relief
    folders = {"relief": (case.folder / "refined-by-relief", ()),
               "published, lambda 0.1": (case.folder / "refined-as-published", (*PUBLISHED, "--lambda", "0.1"))}
    costs = cheapest({name: lambda folder=folder, options=options: relief.cost(
        folder.with_suffix(".log"), "refine", *case.input(), *options, "-o", folder)
        for name, (folder, options) in folders.items()}, context.rounds)
    log = case.folder / "fit.log"
    rows = [row(case, "as measured", None, to_measured=median_angle(relief, case, case.project, case.project, log))]
    for name, (folder, _) in folders.items():
        if isinstance(costs[name], Exception):
            rows.append(row(case, name, costs[name]))
            continue
        project = folder / "scan.json"
        rows.append(row(case, name, costs[name], to_measured=median_angle(relief, case, project, case.project, log),
                        to_corrected=median_angle(relief, case, project, project, log)))
    return rows
