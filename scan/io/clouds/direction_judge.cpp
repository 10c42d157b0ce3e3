#include "scan/io/clouds/direction_judge.h"

#include <algorithm>
#include <cmath>

#include "scan/io/clouds/cloud_direction.h"

namespace relief {

namespace {

constexpr std::size_t kMostPoints = 40000;  // That a direction is judged by; bounds the time.
// Depth behind another point that hides [sides of a cell]: one surface is as deep in a cell of a
// spacing at atan 4 = 76 degrees.
constexpr double kBehind = 4.0;
// Cosine beyond which a normal looks away: 12 degrees past grazing, as estimated ones may err.
constexpr double kAverted = 0.2;

std::int32_t cell(double value) {
  if (std::isnan(value)) return 0;
  return static_cast<std::int32_t>(std::floor(std::clamp(value, -1e9, 1e9)));
}

}  // namespace

DirectionJudge::DirectionJudge(const PointCloudFile& cloud)
    : chosen_(some_points(cloud.points.size(), kMostPoints)), cells_(chosen_.size()) {
  const auto& normals = cloud.facing.empty() ? cloud.normals : cloud.facing;
  for (const std::size_t i : chosen_) {
    points_.push_back(cloud.points[i]);
    if (!normals.empty()) normals_.push_back(normals[i].cast<double>().stableNormalized());
  }
  spacing_ = nearest_spacing(points_);
  for (const auto& point : points_) centre_ += point / static_cast<double>(points_.size());
  for (const auto& point : points_) extent_ = std::max(extent_, (point - centre_).norm());
  // Cells stay countable where the spacing is nothing beside the size.
  spacing_ = std::max(spacing_, 1e-6 * extent_);
}

DirectionScore DirectionJudge::score(const CloudRays& rays) {
  cells_.clear();
  projected_.clear();
  double distance = 0.0;
  for (const auto& point : points_) {
    projected_.push_back(rays.project(point));
    distance += projected_.back().z() / static_cast<double>(points_.size());
  }
  const double size = cell_ * spacing_ / std::max(rays.scale(distance), 1e-300);
  const auto nearest = [&](const Eigen::Vector3d& p) -> double& {
    return cells_.depth(cell(p.x() / size), cell(p.y() / size), p.z());
  };
  for (const auto& p : projected_)
    if (double& depth = nearest(p); p.z() < depth) depth = p.z();
  std::size_t hidden = 0;
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (projected_[i].z() > nearest(projected_[i]) + kBehind * cell_ * spacing_ || averted(i, rays))
      ++hidden;
  return {
      static_cast<double>(hidden) / static_cast<double>(std::max<std::size_t>(1, points_.size())),
      cells_.used()};
}

bool DirectionJudge::averted(std::size_t i, const CloudRays& rays) const {
  if (normals_.empty()) return false;
  const Eigen::Vector3d direction = rays.kind == CloudRays::Kind::kParallel
                                        ? Eigen::Vector3d(rays.axes.col(2))
                                        : (points_[i] - rays.origin).stableNormalized();
  return normals_[i].dot(direction) > kAverted;
}

}  // namespace relief
