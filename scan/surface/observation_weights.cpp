#include "scan/surface/observation_weights.h"

#include <algorithm>
#include <cmath>

namespace relief {

double silhouette_weight(double boundary_distance, int ramp) {
  constexpr double kLeast = 0.1;  // [pixels]; keeps the weight positive.
  return std::min(1.0, (boundary_distance + kLeast) / (ramp + kLeast));
}

Grid<float> observation_weights(const RangeView& view, const ConnectedGrid& grid,
                                const Grid<Eigen::Vector3f>& normals,
                                const ObservationWeightOptions& options) {
  constexpr double kLeastCosine = 0.05;  // 87 degrees; keeps weights positive.
  Grid<float> weights(view.width(), view.height(), 0.0f);
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      double trust = view.confidence_at(u, v);
      const Eigen::Vector3f& normal = normals(u, v);
      if (!view.has_sample(u, v) || !normal.allFinite() || !(trust > 0.0)) continue;
      const double cosine = std::max(
          kLeastCosine, -normal.cast<double>().dot(view.camera.ray(u, v).direction.normalized()));
      if (options.nominal_deviation > 0.0 && view.deviation_at(u, v) > 0.0f)
        trust = std::pow(options.nominal_deviation / (cosine * view.deviation_at(u, v)), 2);
      weights(u, v) = static_cast<float>(
          trust * cosine * silhouette_weight(grid.boundary(u, v), options.silhouette_ramp));
    }
  }
  return weights;
}

}  // namespace relief
