"""What stages and peers start from. Made once per case, outside of all measured times."""

import json

from suite.cases import poses_of, with_poses
from suite.measure import run
from suite.system import PYTHON, ROOT_PEERS


def clouds(case, relief, project, name):
    """Folder of the point clouds of a project, for peers; placed in the world by the project's poses."""
    if name not in case.cached:
        grids, output = case.folder / f"{name}-grids", case.folder / f"{name}-clouds"
        grids.mkdir(parents=True, exist_ok=True)
        relief.grids(project, grids)
        run([PYTHON, ROOT_PEERS / "clouds.py", grids, output], case.folder / f"{name}-clouds.log")
        case.cached[name] = output
    return case.cached[name]


def start_clouds(case, relief):
    """The scans as measured, at their starting poses."""
    return clouds(case, relief, case.project, "start")


def moved(case, relief, motions, name):
    """Projects of the scans as measured: motions (name -> 4x4, in the world) applied to their starting poses."""
    start_clouds(case, relief)
    grids = case.folder / "start-grids" / "scan.json"
    start = poses_of(grids)
    poses = {view: multiply(motion, start[view]) for view, motion in motions.items()}
    return with_poses(grids, poses, f"{name}.json")


def multiply(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def refined(case, relief):
    """The views refined by relief, at their starting poses."""
    folder = case.folder / "refined-by-relief"
    if "refined" not in case.cached:
        if not (folder / "scan.json").exists():
            relief.cost(case.folder / "refine-for-merge.log", "refine", *case.input(), "-o", folder)
        case.cached["refined"] = folder / "scan.json"
    return case.cached["refined"]


def views_to_merge(case, relief):
    """Refined views at their true poses; where no truth is known, or no normals are to refine with, the scans."""
    if not case.truth_poses:
        return case.project
    return with_poses(refined(case, relief), poses_of(case.truth_poses), "true-poses.json")


def motions_of(path):
    return json.loads(path.read_text())["motions"]
