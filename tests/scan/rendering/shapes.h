#pragma once

#include "relief/rendering/picture_camera.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::rendering::testing {

/// A sphere, faces outwards.
TriangleMesh sphere(double radius, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero(),
                    int divisions = 60);

/// [-half, half] x [-half, half] at z = 0 in 2 n^2 faces, seen from above.
TriangleMesh plate(double half, int n = 1);

/// The plate, and on it the wall y = 0 of height `half`, its face towards -y.
TriangleMesh floor_and_wall(double half);

/// Looks along -z from z = 1000, orthographic, x right and y up, (0, 0) in the middle of the
/// picture; `pixel` is the side of a pixel [unit].
PictureCamera from_above(int width, int height, double pixel);

}  // namespace relief::rendering::testing
