#pragma once

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/simulation/range_sensors.h"
#include "scan/simulation/sensors/sensor_scene.h"

namespace relief::simulation {

/// kBadInput names a field out of its range.
Result<void> validate(const TriangulationScanner& scanner);

/// Replaces the exact range of `view`, which is that of `scene.truth`, by what the scanner
/// measures. Lost samples lose their normals too.
void scan_by_triangulation(RangeView& view, const TriangulationScanner& scanner,
                           const SensorScene& scene);

/// Standard deviation of the depth at depth z [unit] of a white surface that faces camera and
/// projector, equation (S5): z^2 / (f b) disparity_noise.
double depth_deviation(const TriangulationScanner& scanner, double z, double distance,
                       double spacing);

}  // namespace relief::simulation
