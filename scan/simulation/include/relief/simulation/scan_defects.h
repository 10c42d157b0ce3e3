#pragma once

#include <optional>

#include "relief/scan/result.h"
#include "relief/simulation/background_plate.h"
#include "relief/simulation/glare.h"
#include "relief/simulation/sensor_scene.h"

namespace relief::simulation {

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

/// kBadInput names a field out of its range.
Result<void> validate(const ScanDefects& defects);

/// Spoils a view that the sensors measured: warp, glare, outliers, steps, then losses. Lost samples
/// lose their normals too.
void spoil_view(RangeView& view, const ScanDefects& defects, const SensorScene& scene);

/// Turns the components of the view's normals into another convention than the view's frame: the
/// normals are then what a wrong file holds, and may face away from the sensor.
void mistake_normals(RangeView& view, NormalMistake mistake, const RigidMotion& world_from_view);

/// The camera that takes the scans whose camera is said to be `stated`: with the distortion that
/// nobody knows of.
Camera true_camera(const Camera& stated, const ScanDefects& defects);

/// Gives a view the camera `stated`, with a wrong focal length, and ranges with a wrong scale and
/// offset. `spacing`: of the samples [unit].
void miscalibrate(RangeView& view, const Camera& stated, const ScanDefects& defects,
                  double spacing);

}  // namespace relief::simulation
