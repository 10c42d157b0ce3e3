#include "scan/io/clouds/direction_judge.h"

#include <algorithm>
#include <cmath>
#include <tuple>

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

// A point in the cell of its ray.
struct PlacedPoint {
  std::int32_t u = 0, v = 0;
  double depth = 0.0;
};

bool share_cell(const PlacedPoint& a, const PlacedPoint& b) { return a.u == b.u && a.v == b.v; }

}  // namespace

DirectionJudge::DirectionJudge(const PointCloudFile& cloud)
    : chosen_(some_points(cloud.points.size(), kMostPoints)), cells_(chosen_.size()) {
  const auto& normals = cloud.facing.empty() ? cloud.normals : cloud.facing;
  for (const std::size_t i : chosen_) {
    points_.push_back(cloud.points[i]);
    if (!normals.empty() && (!cloud.unoriented_normals || !cloud.facing.empty()))
      normals_.push_back(normals[i].cast<double>().stableNormalized());
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

GapScore DirectionJudge::score_gaps(const CloudRays& rays) const {
  std::vector<PlacedPoint> placed;
  double distance = 0.0;
  for (const auto& point : points_) {
    const Eigen::Vector3d p = rays.project(point);
    placed.push_back({0, 0, p.z()});
    distance += p.z() / static_cast<double>(points_.size());
  }
  const double scale = std::max(rays.scale(distance), 1e-300), size = kCell * spacing_ / scale;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector3d p = rays.project(points_[i]);
    placed[i].u = cell(p.x() / size);
    placed[i].v = cell(p.y() / size);
  }
  std::ranges::sort(placed, {}, [](const PlacedPoint& p) { return std::tuple(p.u, p.v, p.depth); });
  // Far off, cells are wider, and samples of a surface are further apart.
  const auto gap = [&](double depth) {
    return kBehind * kCell * spacing_ * std::max(1.0, rays.scale(depth) / scale);
  };
  double shared = 0.0, behind = 0.0;
  bool after_gap = false;
  for (std::size_t i = 1; i < placed.size(); ++i) {
    if (!share_cell(placed[i], placed[i - 1])) {
      after_gap = false;
      continue;
    }
    after_gap |= placed[i].depth - placed[i - 1].depth > gap(placed[i].depth);
    ++shared;
    behind += after_gap ? 1.0 : 0.0;
  }
  if (!(shared > 0.0)) return {};
  // One more point of each kind: no fraction is known without an error.
  const double likely = (behind + 1.0) / (shared + 2.0);
  return {behind / shared, std::sqrt(likely * (1.0 - likely) / shared)};
}

bool DirectionJudge::averted(std::size_t i, const CloudRays& rays) const {
  if (normals_.empty()) return false;
  const Eigen::Vector3d direction = rays.kind == CloudRays::Kind::kParallel
                                        ? Eigen::Vector3d(rays.axes.col(2))
                                        : (points_[i] - rays.origin).stableNormalized();
  return normals_[i].dot(direction) > kAverted;
}

}  // namespace relief
