#include "scan/io/grids/cameras/normal_side.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "scan/base/linear_algebra.h"
#include "scan/base/median.h"
#include "scan/io/normals/normal_convention.h"

namespace relief {

namespace {

constexpr int kRadius = 3;               // of windows [pixels]
constexpr double kMostWindows = 2000.0;  // bounds the time
// [rad], 2 deg between two median angles: 5 standard errors of kMostWindows that scatter by 10 deg.
constexpr double kClearlyCloser = 0.035;

struct Window {
  Eigen::Vector3d surface, stored;  // Unit vectors; the sign of `surface` is arbitrary.
};

// Nothing where the window has gaps.
std::optional<Window> window_at(const GridFile& grid, int u, int v) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), stored = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> points;
  for (int y = v - kRadius; y <= v + kRadius; ++y) {
    for (int x = u - kRadius; x <= u + kRadius; ++x) {
      if (!grid.points.contains(x, y) || !grid.points(x, y).allFinite() ||
          !grid.normals(x, y).allFinite())
        return std::nullopt;
      points.push_back(grid.points(x, y));
      mean += points.back();
      stored += grid.normals(x, y).cast<double>();
    }
  }
  if (!(stored.norm() > 0.0)) return std::nullopt;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& point : points) scatter += (point - mean) * (point - mean).transpose();
  const auto eigen = eigen_decomposition(scatter);
  return Window{eigen.eigenvectors().col(0), stored.normalized()};
}

double median_line_angle(const std::vector<Window>& windows, const Eigen::Matrix3d& convention) {
  std::vector<double> angles;
  for (const Window& window : windows)
    angles.push_back(
        std::acos(std::min(1.0, std::abs(window.surface.dot(convention * window.stored)))));
  return median(angles);
}

}  // namespace

bool normals_tell_side(const GridFile& grid) {
  if (grid.normals.empty()) return false;
  const double pixels = static_cast<double>(grid.points.size());
  const int step = std::max(2 * kRadius + 1, static_cast<int>(std::sqrt(pixels / kMostWindows)));
  std::vector<Window> windows;
  for (int v = kRadius; v < grid.points.height(); v += step)
    for (int u = kRadius; u < grid.points.width(); u += step)
      if (const auto window = window_at(grid, u, v)) windows.push_back(*window);
  const double as_stored = median_line_angle(windows, Eigen::Matrix3d::Identity());
  for (const NormalConvention& other : all_conventions(NormalFileKind::kGrid))
    if (other.space == NormalSpace::kCamera &&
        median_line_angle(windows, other.space_from_stored) < as_stored - kClearlyCloser)
      return false;
  return true;
}

}  // namespace relief
