#pragma once

#include <optional>

namespace relief::simulation {

/// A flat plate behind the object that stands still before the sensor while the object turns, such
/// as a wall or the bed of a turntable's stand. It fills the image, is white and diffuse.
/// The defaults are choices; docs/results.md has figures with them.
struct BackgroundPlate {
  /// From the object's centre to the plate along the sensor's axis, at the working distance
  /// [diameters]; the plate lies outside of the object's sphere: distance x cos(tilt) > 0.5.
  double distance = 0.75;
  double tilt_deg = 20.0;  ///< Between the plate's normal and the sensor's axis, in [0, 80].

  bool operator==(const BackgroundPlate&) const = default;
};

/// Highlights of lamps that stand still before the sensor, on an object that is glossy all over.
/// They wander over the object from view to view and spoil range and normals. The defaults
/// are choices; docs/results.md has figures with them.
struct Glare {
  int lamps = 2;                 ///< Evenly on a cone round the viewing axis, in [1, 64].
  double lamp_angle_deg = 30.0;  ///< Between the lamps and the viewing axis, in (0, 90).
  /// Angle between the normal and the half vector of lamp and viewer at which a highlight has
  /// fallen to 1/e [degrees], in (0, 90).
  double width_deg = 6.0;
  /// Standard deviation of the range error in the middle of a highlight [sample spacings], >= 0; it
  /// is alike over three pixels.
  double range_error = 3.0;

  bool operator==(const Glare&) const = default;
};

/// What is wrong with the convention of the normal maps, in sensor axes x right, y down, z forward.
enum class NormalMistake {
  kNone,
  kFlipX,
  kFlipY,
  kFlipZ,
  kSwapXY,
  kWorldSpace,  ///< The components are those of the world frame.
};

/// What goes wrong on real sensors besides the errors of the sensor models; works with all of them.
/// The defaults change nothing.
struct ScanDefects {
  std::optional<BackgroundPlate> background;  ///< None: the object floats before nothing.

  /// Factor of the range noise in the right half of every image, > 0.
  double noise_half = 1.0;
  /// RMS over each view's samples of a smooth error of the range, a cubic polynomial of the image
  /// coordinates that is another in every view [sample spacings], >= 0.
  double view_warp = 0.0;
  std::optional<Glare> glare;  ///< None: no highlights but those of the sensors' own lights.
  /// Part of the samples that are thrown off along their ray by a normally distributed distance of
  /// standard deviation `outlier_distance` [sample spacings], in [0, 1].
  double outlier_fraction = 0.0;
  double outlier_distance = 20.0;
  double quantisation = 0.0;      ///< Ranges are multiples of this [sample spacings]; 0: any.
  double missing_fraction = 0.0;  ///< Part of the samples that are lost at random, in [0, 1).

  NormalMistake normal_mistake = NormalMistake::kNone;
  /// Factor of the focal length that the scans state, > 0; not 1 for pinhole rays only.
  double focal_factor = 1.0;
  /// Factor of all ranges, poses staying as they are, > 0; not 1 for pinhole rays only.
  double scale_factor = 1.0;
  /// By which part rays at the corner of the image go farther from the axis than the scans state:
  /// the true lens distorts radially, with Brown's k1. > -1/3; not 0 for pinhole rays only.
  double radial_distortion = 0.0;
  double range_offset = 0.0;  ///< Of all ranges, along the rays [sample spacings].
};

}  // namespace relief::simulation
