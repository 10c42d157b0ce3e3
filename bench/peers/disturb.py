"""Moves each view of a project of grid files (`relief convert --grids`) by a random motion, the same in every run.

    disturb.py PROJECT_FOLDER DEGREES SHARE OUTPUT.json [--length] [--seed N]

A view turns by DEGREES about a random axis through the middle of all points and moves by SHARE of the size of the object
(the longest side of the box of all points) in a random direction; with --length SHARE is a length in the unit of the project. OUTPUT lies in
the project's folder: its file names stay valid.
"""

import argparse
import json
import pathlib

import numpy as np
from clouds import columns, read_grid


def direction(random):
    vector = random.standard_normal(3)
    return vector / np.linalg.norm(vector)


def rotation(axis, angle):
    """Rodrigues' formula."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def world_points(project, entry):
    pose = np.array(entry["world_from_view"])
    return columns(read_grid(project / entry["grid"]["file"])[2], "xyz") @ pose[:3, :3].T + pose[:3, 3]


def disturb(project, degrees, share, output, is_length, seed):
    document = json.loads((project / "scan.json").read_text())
    points = np.vstack([world_points(project, entry) for entry in document["views"]])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, distance = (low + high) / 2, share if is_length else share * (high - low).max()
    random = np.random.default_rng(seed)
    for entry in document["views"]:
        motion = np.eye(4)
        motion[:3, :3] = rotation(direction(random), np.radians(degrees))
        motion[:3, 3] = middle - motion[:3, :3] @ middle + distance * direction(random)
        entry["world_from_view"] = (motion @ np.array(entry["world_from_view"])).tolist()
        entry["pose_is"] = "guess"
    output.write_text(json.dumps(document))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Moves each view of a project by a random motion.")
    parser.add_argument("project", type=pathlib.Path)
    parser.add_argument("degrees", type=float)
    parser.add_argument("share", type=float)
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("--length", action="store_true", help="SHARE is a length in the unit of the project")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    disturb(given.project, given.degrees, given.share, given.output, given.length, given.seed)
