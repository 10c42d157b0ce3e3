#pragma once

#include <vector>

#include <Eigen/Core>

#include "relief/scan/camera.h"
#include "relief/scan/rigid_motion.h"
#include "scan/io/images/image_io.h"

namespace relief {

/// |depth - z| / z of the points (world frame) that fall on a pixel with depth: z is that of the
/// point in the view, the pixel the nearest one. Points behind the view are left out. The unit of
/// `depth` is that of the points.
std::vector<double> depth_differences(const Image& depth, const PinholeIntrinsics& intrinsics,
                                      const RigidMotion& world_from_view,
                                      const std::vector<Eigen::Vector3d>& points);

}  // namespace relief
