#pragma once

#include <Eigen/Core>

#include "relief/simulation/simulation_object.h"

namespace relief::simulation {

/// Whether nothing of the object lies between `from`, outside it, and `point` on its surface (both
/// in the world). Surface within 1e-6 of the distance before the point counts as the point itself.
bool in_sight(const SimulationObject& object, const Eigen::Vector3d& from,
              const Eigen::Vector3d& point);

}  // namespace relief::simulation
