"""Screened Poisson reconstruction by Open3D, as its tutorial "Surface reconstruction" does it.

    open3d_poisson.py DEPTH CLOUDS_FOLDER OUTPUT.ply

Takes the normals of the clouds; where there are none, estimates them from 30 neighbours and turns them to the sensor.
Nothing is trimmed: the surface is to be closed.
"""

import json
import pathlib
import sys

import numpy as np
import open3d as o3d


def load(folder):
    description = json.loads((folder / "clouds.json").read_text())
    union = o3d.geometry.PointCloud()
    for view in description["views"]:
        cloud = o3d.io.read_point_cloud(str(folder / f"{view['stem']}.ply"))
        if not cloud.has_normals():
            cloud.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(30))
            if view["position"]:
                cloud.orient_normals_towards_camera_location(np.array(view["position"]))
            else:
                cloud.orient_normals_to_align_with_direction(-np.array(view["direction"]))
        union += cloud
    return union


if __name__ == "__main__":
    mesh, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(load(pathlib.Path(sys.argv[2])),
                                                                        depth=int(sys.argv[1]))
    o3d.io.write_triangle_mesh(sys.argv[3], mesh)
