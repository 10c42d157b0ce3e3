#pragma once

#include "relief/scan/result.h"
#include "relief/simulation/sensor_scene.h"

namespace relief::simulation {

/// A camera that measures how long its own light takes to come back (phase of modulated light).
/// The amplitude of that light, 1 on a white surface that faces the camera at the working
/// distance, rules its noise: albedo x cosine of the incidence x (working distance / range)^2.
/// The defaults are choices; docs/results.md has figures with them.
struct TimeOfFlightCamera {
  /// Standard deviation of the range at amplitude 1 [sample spacings], >= 0.
  double noise = 0.5;
  /// p, in [0, 2]: the noise grows as amplitude^-p. 1: the light of the room rules it; 0.5: the
  /// camera's own light.
  double noise_growth = 1.0;
  double least_amplitude = 0.08;  ///< Samples with less are lost, >= 0.
  /// Part of the samples on either side of an occlusion edge that come out between the two sides,
  /// in [0, 1].
  double flying_fraction = 0.6;
  /// Smooth error by light that went a longer way over other surfaces: never negative, another in
  /// every view. RMS over each view [sample spacings], >= 0.
  double multipath = 2.0;
  double multipath_wavelength = 0.5;  ///< Shortest wave length of its field [diameters], > 0.
  double range_step = 0.5;            ///< Ranges are multiples of this [sample spacings]; 0: any.
};

/// kBadInput names a field out of its range.
Result<void> validate(const TimeOfFlightCamera& camera);

/// Replaces the exact range of `view`, which is that of `scene.truth`, by what the camera
/// measures. Lost samples lose their normals too.
void scan_by_time_of_flight(RangeView& view, const TimeOfFlightCamera& camera,
                            const SensorScene& scene);

}  // namespace relief::simulation
