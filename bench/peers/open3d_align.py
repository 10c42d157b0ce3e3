"""Registration by Open3D, as its tutorials "ICP registration" and "Multiway registration" do it.

    open3d_align.py pairwise|multiway CLOUDS_FOLDER OUTPUT.json

The clouds stand in the world by their starting poses, so every pair starts from the identity. Writes per view the
motion that brings its cloud into place.

Pairs are registered by point-to-plane ICP from coarse to fine, as in the tutorial "Multi-scale ICP": voxels halved from level
to level, correspondences up to about three voxels (there 0.3, 0.14, 0.07 for voxels of 0.1, 0.05, 0.025), normals from 30
neighbours within two voxels. The first voxel is 1 % of the size of the object, so that pairs are found up to 3 % away; the last is one
sample spacing. The multiway tutorial's own distances, 15 voxels and then 1.5, are for clouds that are far apart; from starting
poses as near as these they lose most pairs.

`multiway` registers all pairs and optimises their pose graph. Pairs that share less than 0.3 of their points are left out,
the rule of Open3D's reconstruction system: in the tutorial all pairs overlap, round an object most do not. Pairs of the tree of
greatest overlaps are taken as certain, as the tutorial takes neighbours in a sequence. `pairwise` registers each view to its
neighbour in that tree only.
"""

import json
import pathlib
import sys
import time

import numpy as np
import open3d as o3d

registration = o3d.pipelines.registration
DISTANCE = 3.0  # voxels
MIN_OVERLAP = 0.3


def voxels(spacing, size):
    """From coarse to fine, each half of the one before."""
    sizes = [0.01 * size]
    while sizes[-1] > 1.5 * spacing:
        sizes.append(max(sizes[-1] / 2, spacing))
    return sizes


def pyramid(cloud, sizes):
    """The cloud thinned to each of the voxel sizes, with normals."""
    levels = []
    for voxel in sizes:
        level = cloud.voxel_down_sample(voxel)
        level.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(radius=2 * voxel, max_nn=30))
        levels.append(level)
    return levels


def icp(source, target, sizes):
    """The motion that brings the source to the target, level by level."""
    motion = np.eye(4)
    for voxel, source_level, target_level in zip(sizes, source, target):
        motion = registration.registration_icp(
            source_level, target_level, DISTANCE * voxel, motion,
            registration.TransformationEstimationPointToPlane()).transformation
    return motion


def overlap(source, target, motion, distance):
    """The information of a registered pair, and the part of the smaller cloud that has correspondences."""
    information = registration.get_information_matrix_from_point_clouds(source, target, distance, motion)
    return information, information[5, 5] / min(len(source.points), len(target.points))


def along_tree(clouds, tree, sizes):
    motions = {0: np.eye(4)}
    for source, target, _ in tree:
        motions[source] = motions[target] @ icp(clouds[source], clouds[target], sizes)
    return [motions[i] for i in range(len(clouds))]


def multiway(clouds, tree, sizes):
    graph = registration.PoseGraph()
    coarse, fine = DISTANCE * sizes[0], DISTANCE * sizes[-1]
    certain = {frozenset(edge[:2]) for edge in tree}
    for _ in clouds:
        graph.nodes.append(registration.PoseGraphNode(np.eye(4)))
    for source in range(len(clouds)):
        for target in range(source + 1, len(clouds)):
            if overlap(clouds[source][0], clouds[target][0], np.eye(4), coarse)[1] < MIN_OVERLAP:
                continue
            motion = icp(clouds[source], clouds[target], sizes)
            information, share = overlap(clouds[source][-1], clouds[target][-1], motion, fine)
            if share >= MIN_OVERLAP:
                graph.edges.append(registration.PoseGraphEdge(source, target, motion, information,
                                                              uncertain={source, target} not in certain))
    option = registration.GlobalOptimizationOption(max_correspondence_distance=fine, edge_prune_threshold=0.25,
                                                   reference_node=0)
    registration.global_optimization(graph, registration.GlobalOptimizationLevenbergMarquardt(),
                                     registration.GlobalOptimizationConvergenceCriteria(), option)
    return [node.pose for node in graph.nodes]


def main(mode, folder, output):
    description = json.loads((folder / "clouds.json").read_text())
    sizes = voxels(description["spacing"], description["size"])
    points = [o3d.io.read_point_cloud(str(folder / f"{view['stem']}.ply")) for view in description["views"]]
    read = time.process_time()
    clouds = [pyramid(cloud, sizes) for cloud in points]
    prepared = time.process_time()
    motions = multiway(clouds, description["tree"], sizes) if mode == "multiway" else along_tree(clouds, description["tree"], sizes)
    output.write_text(json.dumps({
        "reading_seconds": read, "preparing_seconds": prepared - read, "pairs_seconds": time.process_time() - prepared,
        "motions": {view["name"]: motion.tolist() for view, motion in zip(description["views"], motions)}}))


if __name__ == "__main__":
    main(sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]))
