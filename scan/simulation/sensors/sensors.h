#pragma once

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/simulation/normal_sensors.h"
#include "relief/simulation/range_sensors.h"
#include "scan/simulation/sensors/sensor_scene.h"

namespace relief::simulation {

/// kBadInput names a field out of its range.
Result<void> validate(const RangeSensor& sensor);
Result<void> validate(const NormalSensor& sensor);

/// The nominal standard deviation of the range at the working distance [unit].
double range_deviation(const RangeSensor& sensor, double distance, double spacing);

/// Replaces the exact normals of `view` by measured ones.
void measure_normals(RangeView& view, const NormalSensor& sensor, const SensorScene& scene);
/// Replaces the exact range of `view` by the measured one; samples may get lost, with their
/// normals.
void measure_range(RangeView& view, const RangeSensor& sensor, const SensorScene& scene);

}  // namespace relief::simulation
