#include "scan/simulation/objects/in_sight.h"

#include "relief/simulation/simulation_object.h"

namespace relief::simulation {

bool in_sight(const SimulationObject& object, const Eigen::Vector3d& from,
              const Eigen::Vector3d& point) {
  const auto hit = object.cast({from, point - from});
  return !hit || hit->range > 1.0 - 1e-6;
}

}  // namespace relief::simulation
