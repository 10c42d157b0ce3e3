#include "scan/io/workspaces/depth_differences.h"

#include <cmath>

namespace relief {

std::vector<double> depth_differences(const Image& depth, const PinholeIntrinsics& intrinsics,
                                      const RigidMotion& world_from_view,
                                      const std::vector<Eigen::Vector3d>& points) {
  const Camera camera = Camera::pinhole(depth.width, depth.height, intrinsics);
  const RigidMotion view_from_world = world_from_view.inverse();
  std::vector<double> differences;
  for (const Eigen::Vector3d& x_in_world : points) {
    const Eigen::Vector3d x_in_view = view_from_world * x_in_world;
    const auto pixel = camera.project(x_in_view);
    if (!pixel || !(pixel->minCoeff() > -0.5) || !(pixel->x() < depth.width - 0.5) ||
        !(pixel->y() < depth.height - 0.5))
      continue;
    const double z =
        depth(static_cast<int>(std::lround(pixel->x())), static_cast<int>(std::lround(pixel->y())));
    if (z > 0.0 && std::isfinite(z))
      differences.push_back(std::abs(z - x_in_view.z()) / x_in_view.z());
  }
  return differences;
}

}  // namespace relief
