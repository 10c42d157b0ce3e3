#include "fusion/views/inter_view_stddev.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "scan/base/median.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Samples that are looked at, of all views. Their median is certain to about 1 %; more cost time.
constexpr std::size_t kSamples = 20'000;

// Differences that make the median mean anything. Fewer come from a rim where views touch.
constexpr std::size_t kFewest = 100;

// Two views see the same surface when their normals differ by less than 60 degrees; the sides of a
// plate and the faces of an edge differ by more.
constexpr double kSameSurface = 0.5;  // Cosine.

// Farther apart than this are two surfaces, not two measurements of one [sample spacings]. More
// lets steps of the object in; less cuts the differences of views that are badly aligned.
constexpr double kFarthest = 8.0;

// Next to a silhouette samples are mixed with what is behind them [pixels].
constexpr double kInside = 2.0;

struct SurfacePoint {
  Eigen::Vector3d position, normal;  // World frame.
  std::size_t view;
};

std::vector<SurfacePoint> points_of(const ViewSampler& view, std::size_t index, std::size_t count) {
  std::size_t all = 0;
  view.for_surface_points([&](const Eigen::Vector3d&) { ++all; });
  const std::size_t step = std::max<std::size_t>(1, all / std::max<std::size_t>(1, count));
  std::vector<SurfacePoint> points;
  std::size_t k = 0;
  view.for_surface_points([&](const Eigen::Vector3d& position) {
    if (k++ % step != 0) return;
    const auto own = view.observe(position, 0.0);
    if (own && own->border >= kInside) points.push_back({position, own->normal, index});
  });
  return points;
}

// Distances of the points of other views to the surface of this one.
std::vector<double> differences(const ViewSampler& view, std::size_t index,
                                const std::vector<SurfacePoint>& points) {
  const double farthest = kFarthest * view.spacing();
  std::vector<double> found;
  for (const SurfacePoint& point : points) {
    if (point.view == index) continue;
    const auto quad = view.quad_on_ray_of(point.position);
    if (!quad || view.side(*quad, 2.0 * farthest) != ViewSampler::Side::kNear) continue;
    const auto seen = view.observe(*quad, farthest);
    if (seen && seen->border >= kInside && seen->normal.dot(point.normal) > kSameSurface &&
        std::abs(seen->distance) < farthest)
      found.push_back(std::abs(seen->distance));
  }
  return found;
}

}  // namespace

double inter_view_stddev(const std::vector<ViewSampler>& views) {
  if (views.size() < 2) return 0.0;
  const std::size_t each = std::max<std::size_t>(1, kSamples / views.size());
  std::vector<SurfacePoint> points;
  for (auto& of_view : parallel_map<std::vector<SurfacePoint>>(
           views.size(), [&](std::size_t i) { return points_of(views[i], i, each); }))
    points.insert(points.end(), of_view.begin(), of_view.end());
  std::vector<double> distances;
  for (auto& of_view : parallel_map<std::vector<double>>(
           views.size(), [&](std::size_t j) { return differences(views[j], j, points); }))
    distances.insert(distances.end(), of_view.begin(), of_view.end());
  if (distances.size() < kFewest) return 0.0;
  return kSigmaPerMedian * median(std::move(distances)) / std::sqrt(2.0);
}

}  // namespace relief::fusion
