#pragma once

#include <variant>

namespace relief::simulation {

/// A range sensor with white noise of one size. The default is a choice that most figures of
/// docs/results.md are measured with.
struct WhiteRangeSensor {
  double noise = 0.3;  ///< Standard deviation along the ray [sample spacings], >= 0; 0: exact.
};

/// A range sensor that triangulates between the ray of a pixel and a second ray, that of a
/// projector or laser: it measures the disparity f b / z [pixels] of each pixel, f being the
/// working distance in sample spacings (for a pinhole its focal length in pixels), b the baseline,
/// z the depth. The second ray leaves the point `baseline` to the right of the origin of the
/// pixel's ray. The defaults are choices, those of structured light; docs/results.md has figures
/// with them.
struct TriangulationScanner {
  double baseline = 0.35;  ///< b [working distances], > 0: 19 degrees of triangulation.

  /// Standard deviation on a white surface that faces camera and projector [pixels], >= 0.
  double disparity_noise = 0.1;
  /// p, in [0, 2]: with less signal the noise grows as signal^-p. 0: it does not; 0.5: light is
  /// counted by photons; 1: the camera itself is noisy.
  double noise_growth = 0.5;
  double noise_correlation = 2.0;      ///< Distance at which its correlation is 1/e [pixels], >= 0.
  double disparity_step = 1.0 / 64.0;  ///< Disparities are multiples of this [pixels]; 0: any.

  /// A sample is lost when its signal, albedo x cosine at the camera x cosine at the projector plus
  /// noise, is below this; >= 0.
  double least_signal = 0.08;
  /// A sample is lost when the light it reflects, that of a white frontal surface being 1, plus
  /// noise, is above this; > 0.
  double saturation = 1.5;
  double signal_noise = 0.03;  ///< Standard deviation of both noises, >= 0; correlated likewise.

  /// Part of the samples on either side of an occlusion edge that come out between the two sides,
  /// in [0, 1].
  double flying_fraction = 0.3;

  /// RMS over the image of the smooth error of the depth that the calibration leaves [sample
  /// spacings], >= 0; the same in all views.
  double warp = 0.2;
};

/// Projected fringes seen by one camera.
TriangulationScanner structured_light_scanner();
/// A swept laser line: more speckle and a wider spot, hence noise of longer correlation and more
/// flying samples; a wider baseline and a coarser peak detector.
TriangulationScanner laser_line_scanner();

/// A pattern of infrared dots and a camera close beside it, as in the first depth cameras:
/// disparity in eighths of a pixel by matching windows, hence steps and noise that grow with the
/// square of the depth and are alike over a window; 75 mm of baseline at 1 m.
TriangulationScanner rgbd_camera();

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

using RangeSensor = std::variant<WhiteRangeSensor, TriangulationScanner, TimeOfFlightCamera>;

}  // namespace relief::simulation
