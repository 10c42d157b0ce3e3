#include "scan/io/clouds/cloud_side.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "relief/scan/range_view.h"

namespace relief {

namespace {

// [spacings] Depths that differ by more are of two surfaces: one is as steep at 72 degrees, atan 3.
constexpr double kStep = 3.0;

// Depths along the rays in spacings, with NaN outside the grid.
class DepthGrid {
 public:
  DepthGrid(const Grid<Eigen::Vector3d>& points, const CloudRays& rays, double spacing)
      : depths_(points.width(), points.height(), kNoSample) {
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i].allFinite()) depths_[i] = rays.project(points[i]).z() / spacing;
  }

  double at(int u, int v) const { return depths_.contains(u, v) ? depths_(u, v) : kNoSample; }
  int width() const { return depths_.width(); }
  int height() const { return depths_.height(); }

  // Whether the surface of a sample ends towards (du, dv). Single gaps are no end.
  bool ends(int u, int v, int du, int dv) const {
    const double next = at(u + du, v + dv), after = at(u + 2 * du, v + 2 * dv);
    const double beside = std::isnan(next) ? after : next;
    return std::isnan(beside) || std::abs(beside - at(u, v)) > kStep;
  }

 private:
  Grid<double> depths_;
};

}  // namespace

double turning_away(const Grid<Eigen::Vector3d>& points, const CloudRays& rays, double spacing) {
  constexpr std::array<std::array<int, 2>, 4> kSides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  const DepthGrid depths(points, rays, spacing);
  double sum = 0.0, count = 0.0;
  for (int v = 0; v < depths.height(); ++v) {
    for (int u = 0; u < depths.width(); ++u) {
      for (const auto& [du, dv] : kSides) {
        // NaN, where there is no sample here or behind, is no slope.
        const double slope = depths.at(u, v) - depths.at(u - du, v - dv);
        if (!(std::abs(slope) <= kStep) || !depths.ends(u, v, du, dv)) continue;
        sum += slope;
        count += 1.0;
      }
    }
  }
  return count > 0.0 ? sum / count : 0.0;
}

}  // namespace relief
