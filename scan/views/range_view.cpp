#include "relief/scan/range_view.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "relief/scan/discontinuities.h"
#include "scan/base/median.h"

namespace relief {

std::size_t RangeView::sample_count() const {
  return static_cast<std::size_t>(
      std::count_if(range.begin(), range.end(), [](double t) { return t == t; }));
}

Grid<Eigen::Vector3d> points_of(const RangeView& view) {
  Grid<Eigen::Vector3d> points(view.width(), view.height(), Eigen::Vector3d::Constant(kNoSample));
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v)) points(u, v) = view.point(u, v);
  return points;
}

double sample_spacing(const RangeView& view) {
  return sample_spacing(points_of(view), connect_samples(view));
}

double sample_spacing(const Grid<Eigen::Vector3d>& points, const GridEdges& edges) {
  std::vector<double> squares;  // Of the lengths.
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (edges.right(u, v)) squares.push_back((points(u + 1, v) - points(u, v)).squaredNorm());
      if (edges.down(u, v)) squares.push_back((points(u, v + 1) - points(u, v)).squaredNorm());
    }
  }
  return std::sqrt(median(squares));
}

}  // namespace relief
