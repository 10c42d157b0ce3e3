#pragma once

#include <cstdint>

#include "relief/scan/range_view.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::testing {

/// A sphere of radius 400 round (0, 0, 1000) with relief: smooth waves of wavelengths of 9 to 70
/// and slopes up to about 0.5, facing a camera at the origin. Lengths are near sample spacings of
/// bumpy_camera.
Surface bumpy_surface();

/// A pinhole camera whose sample spacing on bumpy_surface is close to 1.
Camera bumpy_camera(int width = 256, int height = 256);

/// Turns the normals by a smooth angle of RMS `rms_rad` along each of two tangent directions, of
/// wavelengths near the size of the view.
void add_normal_bias(RangeView& view, double rms_rad);

/// Adds white noise of standard deviation `sigma` [unit] to the range, or to the normals' slopes
/// [rad], that has been averaged over `size` x `size` samples: over long waves it does as much harm
/// as the white noise, from sample to sample about `size` times less.
void add_smoothed_range_noise(RangeView& view, double sigma, int size, std::uint32_t seed);
void add_smoothed_normal_noise(RangeView& view, double sigma_rad, int size, std::uint32_t seed);

/// Replaces a `fraction` of the normals by random ones that face the sensor.
void add_normal_outliers(RangeView& view, double fraction, std::uint32_t seed);

struct ViewErrors {
  double depth_rms = 0.0;  ///< Along the rays [unit].
  double surface_normals =
      0.0;               ///< Mean angle of the finite-difference normals to the true ones [rad].
  double normals = 0.0;  ///< Mean angle of the stored normals to the true ones [rad].
};

/// Of `view` against the noise-free `truth` on the same grid.
ViewErrors errors_of(const RangeView& view, const RangeView& truth);

}  // namespace relief::testing
