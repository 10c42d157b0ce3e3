#pragma once

#include <cstdint>

#include "relief/scan/range_view.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::testing {

/// `surface` with relief that is too shallow for its shape and visible in its normals only: slopes
/// of `slope_deg` RMS made of waves between `shortest` and `longest` [unit].
struct EngravingOptions {
  double slope_deg = 8.0;
  double shortest = 5.0, longest = 25.0;
  std::uint32_t seed = 11;
};
Surface engraved(const Surface& surface, const EngravingOptions& options = {});

/// A cylinder of revolution about the world's y axis, seen from outside.
Surface cylinder(double radius);

/// The flaws of measured views.
struct SensorFlaws {
  double range_noise = 0.3;       ///< [sample spacings]
  double normal_noise_deg = 1.5;  ///< White.
  double normal_bias_deg = 4.0;   ///< RMS, smooth over the view, another one for every seed.
};
void add_flaws(RangeView& view, const SensorFlaws& flaws, std::uint32_t seed);

/// Range noise that is alike over about `reach` pixels either way; `sigma` [unit]: its deviation.
void add_smooth_noise(RangeView& view, double sigma, int reach, std::uint32_t seed);

/// Mean distance [unit] between where two motions put the samples of `view`.
double mean_displacement(const RangeView& view, const RigidMotion& a, const RigidMotion& b);

}  // namespace relief::testing
