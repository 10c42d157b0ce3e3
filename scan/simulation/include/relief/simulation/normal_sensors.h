#pragma once

#include <variant>

namespace relief::simulation {

/// A normal sensor with white noise and a smooth error. The defaults are choices that most figures
/// of docs/results.md are measured with.
struct WhiteNormalSensor {
  double noise_deg = 1.5;        ///< White noise: standard deviation about each tangent axis, >= 0.
  double bias_deg = 4.0;         ///< Smooth error: RMS of its angle over each view, >= 0.
  double bias_wavelength = 0.5;  ///< Its shortest wave length [diameters], > 0.
};

/// A camera that measures normals from the shading under several distant lights (Woodham 1980): it
/// reads the brightness of each pixel under one light at a time and solves for the normal by least
/// squares over the lights that are not in shadow. The defaults are choices; docs/results.md has
/// figures with them.
struct PhotometricStereo {
  int lights = 8;                 ///< Evenly on a cone round the viewing axis, in [3, 64].
  double light_angle_deg = 35.0;  ///< Between the lights and the viewing axis, in (0, 90).
  /// White noise of the readings, stated by its effect on a white surface that faces the camera
  /// with all lights shining: standard deviation of the normal about each tangent axis [degrees],
  /// >= 0. Dark, inclined and partly shadowed surfaces come out noisier.
  double noise_deg = 1.0;
  /// Wrong light directions turn the normals n into A n: RMS of the angle over all directions
  /// [degrees], in [0, 30]; the same in all views.
  double distortion_deg = 2.0;
  double bias_deg =
      1.5;  ///< Smooth error besides: RMS of its angle over each view [degrees], >= 0.
  double bias_wavelength = 0.5;  ///< Its shortest wave length [diameters], > 0.
  /// Reading of a light in attached or cast shadow, of the albedo: light that comes from elsewhere
  /// on the object, in [0, 1].
  double interreflection = 0.08;
  /// Lights below this part of the pixel's brightest reading are left out as shadows, in [0, 1). A
  /// pixel with fewer than three lights left has no normal.
  double shadow_threshold = 0.1;
};

/// The scans carry no normals.
struct NoNormalSensor {};

using NormalSensor = std::variant<WhiteNormalSensor, PhotometricStereo, NoNormalSensor>;

}  // namespace relief::simulation
