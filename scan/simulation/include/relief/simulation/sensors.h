#pragma once

#include <variant>

#include "relief/simulation/photometric_stereo.h"
#include "relief/simulation/time_of_flight.h"
#include "relief/simulation/triangulation_scanner.h"

namespace relief::simulation {

/// A range sensor with white noise of one size. The default is a choice that most figures of
/// docs/results.md are measured with.
struct WhiteRangeSensor {
  double noise = 0.3;  ///< Standard deviation along the ray [sample spacings], >= 0; 0: exact.
};

/// A normal sensor with white noise and a smooth error. The defaults are choices that most figures
/// of docs/results.md are measured with.
struct WhiteNormalSensor {
  double noise_deg = 1.5;        ///< White noise: standard deviation about each tangent axis, >= 0.
  double bias_deg = 4.0;         ///< Smooth error: RMS of its angle over each view, >= 0.
  double bias_wavelength = 0.5;  ///< Its shortest wave length [diameters], > 0.
};

/// The scans carry no normals.
struct NoNormalSensor {};

using RangeSensor = std::variant<WhiteRangeSensor, TriangulationScanner, TimeOfFlightCamera>;
using NormalSensor = std::variant<WhiteNormalSensor, PhotometricStereo, NoNormalSensor>;

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
