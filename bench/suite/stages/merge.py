"""One closed mesh from the same views at the same poses: relief against Poisson reconstruction and TSDF integration."""

import json

from suite.inputs import clouds, views_to_merge
from suite.measure import Failed, cheapest, run
from suite.rows import not_installed, row
from suite.system import PYTHON, ROOT_PEERS


def open3d_poisson(depth):
    def merge(case, folder, output):
        return run([PYTHON, ROOT_PEERS / "open3d_poisson.py", depth, folder, output], output.with_suffix(".log"))[0]
    return merge


def open3d_tsdf(case, folder, output):
    description = json.loads((folder / "clouds.json").read_text())
    if any(view["camera"].get("model") != "pinhole" for view in description["views"]):
        raise Failed("not applicable: takes depth maps of pinhole cameras only")
    return run([PYTHON, ROOT_PEERS / "open3d_tsdf.py", folder, output], output.with_suffix(".log"))[0]


def pcl_poisson(depth):
    def merge(case, folder, output):
        if not json.loads((folder / "clouds.json").read_text())["normals"]:
            raise Failed("not applicable: takes normals, which these scans do not have")
        vtk = output.with_suffix(".vtk")
        cost, _ = run(["pcl_poisson_reconstruction", folder / "all.pcd", vtk, "-depth", depth],
                      output.with_suffix(".log"))
        run(["pcl_vtk2ply", vtk, output], output.with_suffix(".ply.log"))
        return cost
    return merge


PEERS = {"Open3D, Poisson, depth 8": ("Open3D", open3d_poisson(8)),
         "Open3D, Poisson, depth 9": ("Open3D", open3d_poisson(9)),
         "Open3D, Poisson, depth 10": ("Open3D", open3d_poisson(10)),
         "Open3D, TSDF": ("Open3D", open3d_tsdf),
         "PCL, Poisson, depth 9": ("PCL", pcl_poisson(9))}
SLOW = ("Open3D, Poisson, depth 10", "PCL, Poisson, depth 9")  # minutes a case: only where the case says so
QUICK = ("Open3D, Poisson, depth 8", "Open3D, TSDF")


def figures_of(case, relief, mesh, log):
    """Lengths in sample spacings. The first threshold is half a spacing, the second two."""
    report = relief.figures(log, "evaluate", mesh, "--truth", case.truth_mesh, "--threshold",
                            0.5 * case.spacing, 2 * case.spacing)
    side = lambda part: {"rms": part["rms"] / case.spacing, "median": part["median"] / case.spacing,
                         "p95": part["p95"] / case.spacing, "normals": part["normals_deg"]["mean"],
                         "within": part["within"]}
    topology = report["topology"]
    closed = topology["boundary_edges"] == 0 and all(
        topology[key] for key in ("manifold_edges", "manifold_vertices", "oriented"))
    figures = {"accuracy": side(report["accuracy"]), "completeness": side(report["completeness"]), "closed": closed,
               "degenerate": topology["degenerate_faces"], "boundary_edges": topology["boundary_edges"],
               "non_manifold": topology["non_manifold_edges"] + topology["non_manifold_vertices"],
               "components": topology["components"], "genus": topology["genus"], "vertices": topology["vertices"],
               "filled": report["filled_area_fraction"]}
    if "measured" in report["accuracy"]:
        figures["measured"] = side(report["accuracy"]["measured"])
    return figures


def closed_by_admesh(relief, mesh, programs):
    """What an independent program says of a mesh: whether all its edges have two faces. None: not installed."""
    if not programs.has("admesh"):
        return None
    stl = mesh.with_suffix(".stl")
    run(relief.command("convert", "-q", mesh, "-o", stl), stl.with_suffix(".log"))
    _, output = run(["admesh", "--no-check", "--exact", stl], stl.with_suffix(".admesh.log"))
    stl.unlink()
    counts = {}
    for line in output.splitlines():
        if ":" in line:
            name, value = line.split(":", 1)
            counts[name.strip()] = value.split()
    disconnected = counts.get("Total disconnected facets", ["?"])
    return disconnected[0] == "0"


def measure(case, context):
    relief = context.relief
    project = views_to_merge(case, relief)
    own = case.folder / "merged-by-relief.ply"
    peers = {name: peer for name, peer in PEERS.items()
             if (name in QUICK if context.quick else case.slow_peers or name not in SLOW)}
    installed = {name: peer for name, (program, peer) in peers.items() if context.programs.has(program)}
    folder = clouds(case, relief, project, "merge") if installed else None
    output = {name: case.folder / (name.lower().replace(", ", "-").replace(" ", "-") + ".ply") for name in peers}

    methods = {"relief": lambda: relief.cost(case.folder / "merge.log", "merge", project, *case.options, "-o", own)}
    for name, peer in installed.items():
        methods[name] = lambda name=name, peer=peer: peer(case, folder, output[name])
    costs = cheapest(methods, context.rounds)

    if isinstance(costs["relief"], Exception):
        rows = [row(case, "relief", costs["relief"])]
    else:
        rows = [row(case, "relief", costs["relief"], **figures_of(case, relief, own, own.with_suffix(".errors.log")),
                    admesh=closed_by_admesh(relief, own, context.programs))]
    for name in peers:
        if name not in installed:
            rows.append(not_installed(case, name))
        elif isinstance(costs[name], Exception):
            rows.append(row(case, name, costs[name]))
        else:
            rows.append(row(case, name, costs[name],
                            **figures_of(case, relief, output[name], output[name].with_suffix(".errors.log"))))
    return rows
