#include "fusion/views/view_difference.h"

#include <limits>

namespace relief::fusion {

namespace {

// As for inter_view_errors(): farther apart are two surfaces [sample spacings], and normals that
// differ by more than 60 degrees are those of two.
constexpr double kOtherSurface = 8.0;
constexpr double kAlikeNormals = 0.5;  // Cosine.

double farthest_of(const ViewSampler& view) { return kOtherSurface * view.spacing(); }

}  // namespace

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
  if (seen->distance < -farthest || seen->normal.dot(normal) < kAlikeNormals) return std::nullopt;
  return ViewDifference{seen->distance, seen->relative_stddev};
}

}  // namespace relief::fusion
