"""Finding the poses from the same starting poses: relief against ICP and pose graphs of others."""

import json
import re

from suite.cases import ROOT
from suite.inputs import moved, motions_of, multiply, start_clouds
from suite.measure import Cost, Failed, cheapest, run
from suite.rows import not_installed, row
from suite.system import PYTHON, ROOT_PEERS

IDENTITY = [[1.0 if i == j else 0.0 for j in range(4)] for i in range(4)]


def description_of(folder):
    return json.loads((folder / "clouds.json").read_text())


def matrix_of(text):
    """The last 4x4 matrix in a program's output."""
    number = r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?"
    rows = re.findall(rf"^\s*({number})\s+({number})\s+({number})\s+({number})\s*$", text, re.MULTILINE)
    if len(rows) < 4:
        raise Failed("no transformation in the program's output")
    return [[float(value) for value in line] for line in rows[-4:]]


def along_tree(folder, register):
    """Registers each view to its neighbour in the tree of overlaps; `register` gives cost and motion of a pair."""
    description = description_of(folder)
    stems = [view["stem"] for view in description["views"]]
    motions, cost = {0: IDENTITY}, Cost()
    for source, target, overlap in description["tree"]:
        pair_cost, motion = register(folder / stems[source], folder / stems[target], overlap)
        motions[source] = multiply(motions[target], motion)
        cost = cost + pair_cost
    names = [view["name"] for view in description["views"]]
    return cost, {names[i]: motion for i, motion in motions.items()}


def open3d(mode):
    def align(case, folder):
        output = case.folder / f"open3d-{mode}.json"
        cost, _ = run([PYTHON, ROOT_PEERS / "open3d_align.py", mode, folder, output],
                      case.folder / f"open3d-{mode}.log")
        return cost, motions_of(output)
    return align


def relief_pairwise(case, folder):
    """Two views at a time, as the peers do it; `relief align` itself never does."""
    output = case.folder / "relief-pairwise.json"
    cost, _ = run([PAIRWISE, case.project, folder / "clouds.json", output], case.folder / "relief-pairwise.log")
    return cost, motions_of(output)


def pcl(case, folder):
    """pcl_icp's default distance, 0.05, is for rooms in metres; here it is 3 % of the object's size, as for Open3D."""
    distance = 0.03 * description_of(folder)["size"]

    def register(source, target, _):
        work = case.folder / "pcl-icp"  # pcl_icp writes its results into the current folder
        work.mkdir(exist_ok=True)
        cost, output = run(["pcl_icp", "-d", f"{distance:.4g}", "-r", f"{distance:.4g}", f"{target}.pcd", f"{source}.pcd"],
                           work / "pcl_icp.log", cwd=work)
        return cost, matrix_of(output)
    return along_tree(folder, register)


def pcl_planes(case, folder):
    """PCL's point-to-plane ICP, for which it has no program, as Open3D's is called."""
    output = case.folder / "pcl-planes.json"
    cost, _ = run([PCL_PLANES, folder, output], case.folder / "pcl-planes.log")
    return cost, motions_of(output)


def pcl_tutorial(case, folder):
    """PCL's tutorial of incremental registration, for which it has no program either."""
    output = case.folder / "pcl-tutorial.json"
    cost, _ = run([PCL_TUTORIAL, folder, output], case.folder / "pcl-tutorial.log")
    return cost, motions_of(output)


def cloudcompare(case, folder):
    """The overlap, which its users have to state, is that of the starting poses, rounded down to 10 %."""
    def register(source, target, overlap):
        percent = max(10, min(100, int(10 * overlap) * 10))
        result = source.with_name(source.name + "_REGISTRATION_MATRIX.txt")
        result.unlink(missing_ok=True)
        cost, _ = run(["xvfb-run", "-a", "CloudCompare", "-SILENT", "-AUTO_SAVE", "OFF", "-NO_TIMESTAMP",
                       "-O", f"{source}.ply", "-O", f"{target}.ply", "-ICP", "-OVERLAP", percent,
                       "-RANDOM_SAMPLING_LIMIT", "60000"], case.folder / "cloudcompare.log")
        return cost, matrix_of(result.read_text())
    return along_tree(folder, register)


PROGRAMS = ROOT / "build/bench/bench"  # cmake --preset bench && cmake --build --preset bench
PAIRWISE, PCL_PLANES, PCL_TUTORIAL = (PROGRAMS / f"relief_{name}" for name in ("pairwise_icp", "pcl_align", "pcl_tutorial"))
PEERS = {"Open3D, multiway": ("Open3D", open3d("multiway")),
         "Open3D, ICP along the tree": ("Open3D", open3d("pairwise")),
         "PCL, ICP along the tree": ("PCL", pcl),
         "CloudCompare, ICP along the tree": ("CloudCompare", cloudcompare)}
SLOW = ("PCL, ICP along the tree", "CloudCompare, ICP along the tree")  # minutes a case: only where the case says so


def figures_of(case, relief, project, log):
    poses = relief.figures(log, "evaluate", project, "--truth", case.truth_poses)["poses"]
    worst = max(view["mean_displacement"] for view in poses["views"])
    return {"displacement": poses["mean_displacement"] / case.spacing, "worst_view": worst / case.spacing,
            "rotation_deg": poses["mean_rotation_deg"]}


def measure(case, context):
    relief, output = context.relief, case.folder / "aligned-by-relief.json"
    peers = {name: peer for name, peer in PEERS.items() if case.slow_peers or name not in SLOW}
    installed = {name: peer for name, (program, peer) in peers.items() if context.programs.has(program)}
    ours = {"relief, ICP along the tree": (PAIRWISE, relief_pairwise),
            "PCL, point-to-plane ICP along the tree": (PCL_PLANES, pcl_planes)}
    for name, (program, peer) in ours.items():
        if program.exists():
            peers[name], installed[name] = (program.name, peer), peer
    folder = start_clouds(case, relief) if installed else None
    motions = {}

    def aligning(name, peer):
        def align():
            cost, motions[name] = peer(case, folder)
            return cost
        return align

    methods = {"relief": lambda: relief.cost(case.folder / "align.log", "align", *case.input(), "-o", output)}
    methods.update({name: aligning(name, peer) for name, peer in installed.items()})
    costs = cheapest(methods, context.rounds)

    rows = [row(case, "starting poses", None, **figures_of(case, relief, case.project, case.folder / "start.log"))]
    rows.append(row(case, "relief", costs["relief"]) if isinstance(costs["relief"], Exception) else row(
        case, "relief", costs["relief"], **figures_of(case, relief, output, case.folder / "align-errors.log")))
    for name in peers:
        if name not in installed:
            rows.append(not_installed(case, name))
        elif isinstance(costs[name], Exception):
            rows.append(row(case, name, costs[name]))
        else:
            project = moved(case, relief, motions[name], re.sub(r"\W+", "-", name.lower()))
            figures = figures_of(case, relief, project, project.with_suffix(".log"))
            rows.append(row(case, name, costs[name], **figures))
    return rows
