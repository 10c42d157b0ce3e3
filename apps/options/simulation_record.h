#pragma once

#include "apps/reports/report.h"
#include "relief/simulation/simulate.h"

namespace relief {

/// Everything that made a simulation, for its truth.json: the seed, the sensors with all their
/// parameters, and the sizes they came to in the unit of the object.
Json simulation_record(const simulation::Simulation& simulation,
                       const simulation::SimulationOptions& options);

}  // namespace relief
