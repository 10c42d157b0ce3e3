#include "scan/simulation/sensors/edge_mixer.h"

#include <cstddef>
#include <utility>

namespace relief::simulation {

EdgeMixer::EdgeMixer(double fraction, const SensorScene& scene)
    : fraction_(fraction),
      truth_(scene.truth),
      edges_(connect_samples(scene.truth)),
      random_(scene.of_view(kFlyingSamples).seed, scene.of_view(kFlyingSamples).stream) {}

EdgeMixer::Mixture EdgeMixer::at(int u, int v) const {
  const double own = truth_.range(u, v);
  const std::size_t pixel = truth_.range.index(u, v);
  for (const auto& [du, dv] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    if (!truth_.has_sample(u + du, v + dv) || edges_.connected(u, v, du, dv)) continue;
    if (random_.uniform(2 * pixel) >= fraction_) return {0.0, own};
    // A pixel lies mostly on its own side.
    return {0.5 * random_.uniform(2 * pixel + 1), truth_.range(u + du, v + dv)};
  }
  return {0.0, own};
}

}  // namespace relief::simulation
