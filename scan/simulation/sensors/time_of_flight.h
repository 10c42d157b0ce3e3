#pragma once

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/simulation/range_sensors.h"
#include "scan/simulation/sensors/sensor_scene.h"

namespace relief::simulation {

/// kBadInput names a field out of its range.
Result<void> validate(const TimeOfFlightCamera& camera);

/// Replaces the exact range of `view`, which is that of `scene.truth`, by what the camera
/// measures. Lost samples lose their normals too.
void scan_by_time_of_flight(RangeView& view, const TimeOfFlightCamera& camera,
                            const SensorScene& scene);

}  // namespace relief::simulation
