#pragma once

#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "relief/scan/result.h"
#include "relief/simulation/simulate.h"

namespace relief {

/// The sensors named on a command line and the single parameters set on top of them.
struct SensorChoice {
  std::string range = "white", normal = "white";
  std::vector<std::function<Result<void>(simulation::SimulationOptions&)>> overrides;

  /// Puts the presets, then the single parameters into `options`. kBadInput when a parameter does
  /// not belong to the chosen sensor.
  Result<void> apply(simulation::SimulationOptions& options) const;
};

/// Adds the options of where sensors stand, how many pixels they have, and starting poses.
void add_simulation_options(CLI::App& command, simulation::SimulationOptions& options);

/// Adds --range-sensor, --normal-sensor and every parameter of the sensors.
void add_sensor_options(CLI::App& command, SensorChoice& choice);

}  // namespace relief
