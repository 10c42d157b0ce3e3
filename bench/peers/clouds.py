"""Point clouds of a project of grid files (`relief convert --grids`), as the peers read them.

    clouds.py PROJECT_FOLDER OUTPUT_FOLDER

Writes per view NAME.ply and NAME.pcd (points and normals in the world, placed by the poses of the project), and for
pinhole cameras NAME.npy, the depth map; all views together as all.ply and all.pcd; and clouds.json, which lists them
with their cameras, poses, the tree of overlapping pairs, the spacing of the samples, and the size of all together, the longest side of
their box.
"""

import json
import pathlib
import sys

import numpy as np

PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
             "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4",
             "uint32": "u4", "float32": "f4", "float64": "f8"}


def read_grid(path):
    """Columns, rows, the vertices as a structured array, and each vertex's place in the grid."""
    with open(path, "rb") as file:
        size, properties, counts, element = {}, [], {}, None
        for line in iter(lambda: file.readline().decode().split(), ["end_header"]):
            if line[0] == "obj_info":
                size[line[1]] = int(line[2])
            elif line[0] == "element":
                element = line[1]
                counts[element] = int(line[2])
            elif line[0] == "property" and element == "vertex":
                properties.append((line[2], "<" + PLY_TYPES[line[1]]))
        vertices = np.frombuffer(file.read(np.dtype(properties).itemsize * counts["vertex"]), properties)
        lists = file.read()
    return size["num_cols"], size["num_rows"], vertices, grid_places(lists, counts["range_grid"], len(vertices))


def grid_places(lists, cells, vertices):
    """Lists of no or one vertex (one byte for the count, four for the number): the cells that have one."""
    places = np.zeros(vertices, np.int64)
    data = np.frombuffer(lists, np.uint8)
    position = 0
    for cell in range(cells):
        if data[position]:
            places[int.from_bytes(lists[position + 1:position + 5], "little")] = cell
            position += 5
        else:
            position += 1
    return places


def columns(vertices, names):
    return np.stack([vertices[name].astype(np.float64) for name in names], axis=1)


def write_ply(path, points, normals):
    data = np.hstack([points, normals]).astype("<f4") if normals is not None else points.astype("<f4")
    names = ["x", "y", "z", "nx", "ny", "nz"][:data.shape[1]]
    header = "".join(f"property float {name}\n" for name in names)
    with open(path, "wb") as file:
        file.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(data)}\n{header}end_header\n".encode())
        file.write(data.tobytes())


def write_pcd(path, points, normals):
    data = np.hstack([points, normals]).astype("<f4") if normals is not None else points.astype("<f4")
    names = ["x", "y", "z", "normal_x", "normal_y", "normal_z"][:data.shape[1]]
    n = len(names)
    with open(path, "wb") as file:
        file.write((f"# .PCD v0.7\nVERSION 0.7\nFIELDS {' '.join(names)}\nSIZE {' '.join(['4'] * n)}\n"
                    f"TYPE {' '.join(['F'] * n)}\nCOUNT {' '.join(['1'] * n)}\nWIDTH {len(data)}\nHEIGHT 1\n"
                    f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(data)}\nDATA binary\n").encode())
        file.write(data.tobytes())


def spacing_of(points, places, width):
    """Median distance of neighbours along rows."""
    order = np.argsort(places)
    neighbours = (np.diff(places[order]) == 1) & (places[order][1:] % width != 0)
    steps = np.linalg.norm(np.diff(points[order], axis=0), axis=1)
    return float(np.median(steps[neighbours]))


def occupied(points, cell):
    return set(map(tuple, np.unique(np.floor(points / cell).astype(np.int64), axis=0)))


def overlap_tree(clouds, cell):
    """A spanning tree of the views by greatest overlap, from the first view: [source, target, overlap], in the
    order in which views are to be added. Overlap: part of the source's cells of size `cell` that the target has."""
    cells = [occupied(points, cell) for points in clouds]
    share = lambda a, b: len(cells[a] & cells[b]) / len(cells[a])
    tree, inside = [], [0]
    while len(inside) < len(clouds):
        outside = [i for i in range(len(clouds)) if i not in inside]
        source, target = max(((a, b) for a in outside for b in inside), key=lambda pair: share(*pair))
        tree.append([source, target, share(source, target)])
        inside.append(source)
    return tree


def shared_direction(document):
    """Where the sensors of a set look, in their own frames: the mean over the views that say so, for those that do not. None where
    no view does."""
    known = [entry["camera"]["view_direction"] for entry in document["views"] if entry.get("camera", {}).get("view_direction")]
    return np.mean(np.array(known, float), axis=0) if known else None


def sensor_direction(camera, shared, world_from_view):
    """Where the sensor looks, in the world, and where it is; a sensor of parallel rays is nowhere."""
    direction = camera.get("view_direction", shared)
    if camera.get("model") in ("pinhole", "pinhole_gl") or direction is None:
        return None, world_from_view[:3, 3].tolist()
    return (world_from_view[:3, :3] @ np.array(direction)).tolist(), None


def convert(project, output):
    document = json.loads((project / "scan.json").read_text())
    views, clouds, all_normals, spacings = [], [], [], []
    shared = shared_direction(document)
    for entry in document["views"]:
        width, height, vertices, places = read_grid(project / entry["grid"]["file"])
        pose = np.array(entry.get("world_from_view", np.eye(4)))
        local = columns(vertices, "xyz")
        points = local @ pose[:3, :3].T + pose[:3, 3]
        normals = columns(vertices, ["nx", "ny", "nz"]) if "nx" in vertices.dtype.names else None
        if normals is not None:
            has_normal = np.isfinite(normals).all(axis=1) & (np.abs(normals).sum(axis=1) > 0.5)
            normals = normals @ pose[:3, :3].T
        spacings.append(spacing_of(points, places, width))
        stem = pathlib.Path(entry["grid"]["file"]).stem
        keep = slice(None) if normals is None else has_normal
        kept_normals = None if normals is None else normals[keep]
        write_ply(output / f"{stem}.ply", points[keep], kept_normals)
        write_pcd(output / f"{stem}.pcd", points[keep], kept_normals)
        camera = entry.get("camera", {})
        if camera.get("model") == "pinhole":
            depth = np.zeros(width * height, np.float32)
            depth[places] = local[:, 2]
            np.save(output / f"{stem}.npy", depth.reshape(height, width))
        direction, position = sensor_direction(camera, shared, pose)
        views.append({"name": entry["name"], "stem": stem, "camera": camera, "world_from_view": pose.tolist(),
                      "direction": direction, "position": position})
        clouds.append(points[keep])
        all_normals.append(kept_normals)
    spacing = float(np.median(spacings))
    everything = np.vstack(clouds)
    size = float((everything.max(axis=0) - everything.min(axis=0)).max())
    with_normals = all(normals is not None for normals in all_normals)
    union = np.vstack(all_normals) if with_normals else None
    write_ply(output / "all.ply", everything, union)
    write_pcd(output / "all.pcd", everything, union)
    tree = overlap_tree(clouds, 10 * spacing)
    (output / "clouds.json").write_text(json.dumps(
        {"spacing": spacing, "size": size, "normals": with_normals, "views": views, "tree": tree}, indent=1))


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[2])
    target.mkdir(parents=True, exist_ok=True)
    convert(pathlib.Path(sys.argv[1]), target)
