"""Integration of depth maps by Open3D, as its tutorial "RGBD integration" does it.

    open3d_tsdf.py CLOUDS_FOLDER OUTPUT.ply

A voxel is one sample spacing long; distances are truncated at five voxels, the proportion of the tutorial.
"""

import json
import pathlib
import sys

import numpy as np
import open3d as o3d


def integrate(folder):
    description = json.loads((folder / "clouds.json").read_text())
    voxel = description["spacing"]
    integration = o3d.pipelines.integration
    volume = integration.ScalableTSDFVolume(voxel_length=voxel, sdf_trunc=5 * voxel,
                                            color_type=integration.TSDFVolumeColorType.NoColor)
    for view in description["views"]:
        depth = o3d.geometry.Image(np.load(folder / f"{view['stem']}.npy"))
        height, width = np.asarray(depth).shape
        colour = o3d.geometry.Image(np.zeros((height, width, 3), np.uint8))
        image = o3d.geometry.RGBDImage.create_from_color_and_depth(
            colour, depth, depth_scale=1.0, depth_trunc=1e9, convert_rgb_to_intensity=False)
        camera = view["camera"]
        intrinsic = o3d.camera.PinholeCameraIntrinsic(width, height, camera["fx"], camera["fy"], camera["cx"],
                                                      camera["cy"])
        volume.integrate(image, intrinsic, np.linalg.inv(np.array(view["world_from_view"])))
    return volume.extract_triangle_mesh()


if __name__ == "__main__":
    o3d.io.write_triangle_mesh(sys.argv[2], integrate(pathlib.Path(sys.argv[1])))
