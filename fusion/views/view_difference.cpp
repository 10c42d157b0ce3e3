#include "fusion/views/view_difference.h"

#include <algorithm>
#include <limits>

namespace relief::fusion {

namespace {

double farthest_of(const ViewSampler& view) { return kFarthest * view.spacing(); }

}  // namespace

std::vector<ObservedSample> some_samples(const ViewSampler& view, std::size_t count) {
  std::size_t all = 0, k = 0;
  view.for_surface_points([&](const Eigen::Vector3d&) { ++all; });
  const std::size_t step = std::max<std::size_t>(1, all / std::max<std::size_t>(1, count));
  std::vector<ObservedSample> samples;
  view.for_surface_points([&](const Eigen::Vector3d& position) {
    if (k++ % step != 0) return;
    const auto own = view.observe(position, 0.0);
    if (own && own->border >= kInside) samples.push_back({position, *own});
  });
  return samples;
}

double reach_of_difference(const ViewSampler& view) { return 2.0 * farthest_of(view); }

std::optional<ViewDifference> difference_from(const ViewSampler& view,
                                              const Eigen::Vector3d& position,
                                              const Eigen::Vector3d& normal, double inside) {
  const double farthest = farthest_of(view);
  const auto quad = view.quad_on_ray_of(position);
  if (!quad || view.side(*quad, reach_of_difference(view)) == ViewSampler::Side::kBehind)
    return std::nullopt;
  const auto seen = view.observe(*quad, farthest);
  if (!seen || seen->noisy || seen->border < inside) return std::nullopt;
  if (seen->distance > farthest)
    return ViewDifference{std::numeric_limits<double>::infinity(), seen->relative_stddev};
  if (seen->distance < -farthest || seen->normal.dot(normal) < kSameSurfaceCosine)
    return std::nullopt;
  return ViewDifference{seen->distance, seen->relative_stddev};
}

}  // namespace relief::fusion
