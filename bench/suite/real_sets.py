"""Real sets as projects: with poses in the conventions of relief, off their poses, or without any and in another order."""

import json
import pathlib
import random
import shutil

from suite.measure import run
from suite.system import PYTHON, ROOT_PEERS


def rotation(qx, qy, qz, qw):
    return [[1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw)],
            [2 * (qx * qy + qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qx * qw)],
            [2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx * qx + qy * qy)]]


def icl_nuim(source, folder):
    """A project of depth images (metres x 5000) and `pose.txt`, a line `tx ty tz qx qy qz qw` per image, camera to world. The set's
    camera has fy = -480: its y points up, so that its frame is left-handed. Turning y over, in cameras and world alike, gives fy = 480
    and rigid motions."""
    folder.mkdir(parents=True, exist_ok=True)
    images = sorted((source / "depth").glob("*.png"), key=lambda path: (len(path.stem), path.stem))
    lines = [line.split() for line in (source / "pose.txt").read_text().splitlines() if line.strip()]
    views = []
    for image, line in zip(images, lines, strict=True):
        shutil.copy(image, folder / image.name)
        x, y, z, *quaternion = (float(word) for word in line)
        turn = rotation(*quaternion)
        sign = [1, -1, 1]
        rows = [[sign[i] * turn[i][j] * sign[j] for j in range(3)] + [sign[i] * (x, y, z)[i]] for i in range(3)]
        views.append({"name": image.stem, "depth": {"file": image.name, "scale": 1 / 5000, "kind": "z"},
                      "camera": {"model": "pinhole", "width": 640, "height": 480, "fx": 481.2, "fy": 480, "cx": 319.5, "cy": 239.5},
                      "world_from_view": [*rows, [0, 0, 0, 1]], "pose_is": "guess"})
    write_project(folder / "scan.json", "m", views)
    return folder / "scan.json"


def write_project(path, unit, views):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"format": "relief-scan", "version": 1, "unit": unit, "views": views}, indent=1) + "\n")


def beside(grids, entry):
    """A view of the project in the folder `grids`, for a project in a folder beside it."""
    entry = json.loads(json.dumps(entry))
    for part in entry.values():
        if isinstance(part, dict) and "file" in part:
            part["file"] = str(pathlib.Path("..") / grids.name / part["file"])
    return entry


def start_project(grids, folder, kind, seed, off):
    """The project of grid files in `grids` as a program is to start from it. `kind`: `given` poses; `off`: turned by degrees and moved by a
    length in its unit, the pair `off`; `none`: without poses, in a random order."""
    document = json.loads((grids / "scan.json").read_text())
    if kind == "off":
        moved = grids / f"off-{seed}.json"
        run([PYTHON, ROOT_PEERS / "disturb.py", grids, off[0], off[1], moved, "--length", "--seed", seed], folder.with_suffix(".log"))
        document = json.loads(moved.read_text())
        moved.unlink()
    views = [beside(grids, entry) for entry in document["views"]]
    for entry in views:
        if kind == "none":
            entry.pop("world_from_view", None)
            entry.pop("pose_is", None)
        elif "world_from_view" in entry:
            entry["pose_is"] = "guess"
    if kind == "none":
        random.Random(seed).shuffle(views)
    write_project(folder / "scan.json", document["unit"], views)
    return folder / "scan.json"
