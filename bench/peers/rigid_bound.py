"""What a smooth or systematic error of the views leaves in a model, whatever rigid motions the views are given.

    rigid_bound.py EXACT_FOLDER WRONG_FOLDER

Both folders hold the same simulated views as grid files (`relief convert --grids`) with their true normals: EXACT without any error,
WRONG with the systematic error alone. Per view the rigid motion is removed that brings the wrong points nearest to the exact
surface (point-to-plane, small angles). What is left along the normals is averaged over all samples that fall into one cell of two sample
spacings, as a model averages views. Prints as JSON, in sample spacings, the RMS of what is left, `view` (single samples) and `model` (cells), and
`motion`: the RMS along the rays of the motions that were removed. No views can tell such a motion from their poses: it stays in their
ranges.
"""

import json
import pathlib
import sys

import numpy as np
from clouds import columns, read_grid, spacing_of


def load(folder):
    document = json.loads((folder / "scan.json").read_text())
    for entry in document["views"]:
        width, _, vertices, places = read_grid(folder / entry["grid"]["file"])
        order = np.argsort(places)
        yield (places[order], columns(vertices, "xyz")[order], columns(vertices, ["nx", "ny", "nz"])[order],
               np.array(entry["world_from_view"], float), width)


LEAST_COSINE = 0.3  # Steeper rays make a motion along the normal any length along the ray.


def left_over(points, normals, displacements):
    """Along the normals, after the best small motion; and that motion along the rays of a pinhole camera."""
    usable = np.isfinite(normals).all(axis=1) & (np.abs(normals).sum(axis=1) > 0.5)
    points, normals, displacements = points[usable], normals[usable], displacements[usable]
    middle = points.mean(axis=0)
    rows = np.hstack([np.cross(points - middle, normals), normals])
    along = np.einsum("ni,ni->n", displacements, normals)
    motion, *_ = np.linalg.lstsq(rows, along, rcond=None)
    cosines = np.abs(np.einsum("ni,ni->n", normals, points)) / np.linalg.norm(points, axis=1)
    frontal = cosines > LEAST_COSINE
    return usable, along - rows @ motion, (rows @ motion)[frontal] / cosines[frontal]


def bound(exact, wrong):
    cells, errors, motions, spacings = [], [], [], []
    for (places, points, normals, pose, width), (wrong_places, wrong_points, *_) in zip(load(exact), load(wrong)):
        _, first, second = np.intersect1d(places, wrong_places, return_indices=True)
        usable, error, motion = left_over(points[first], normals[first], wrong_points[second] - points[first])
        errors.append(error)
        motions.append(motion)
        cells.append(points[first][usable] @ pose[:3, :3].T + pose[:3, 3])
        spacings.append(spacing_of(points, places, width))
    spacing = float(np.median(spacings))
    errors = np.concatenate(errors)
    _, cell = np.unique(np.floor(np.vstack(cells) / (2 * spacing)).astype(np.int64), axis=0, return_inverse=True)
    means = np.bincount(cell, errors) / np.bincount(cell)
    rms = lambda values: float(np.sqrt(np.mean(values ** 2))) / spacing
    return {"view": rms(errors), "model": rms(means), "motion": rms(np.concatenate(motions))}


if __name__ == "__main__":
    print(json.dumps(bound(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))))
