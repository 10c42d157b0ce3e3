#pragma once

#include <cstdint>

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "relief/simulation/simulation_object.h"
#include "scan/simulation/base/random_stream.h"
#include "scan/simulation/objects/reflectance.h"

namespace relief::simulation {

/// The kinds of error that draw random numbers, from 1.
enum SensorErrorKind : std::uint64_t {
  kDisparityNoise = 1,
  kSignalNoise,
  kFlyingSamples,
  kCalibrationWarp,
  kReadingNoise,
  kNormalDistortion,
  kPhotometricBias,
  kDarkPatches,
  kGlossyPatches,
  kViewWarp,
  kOutliers,
  kMissingSamples,
  kFlightNoise,
  kMultipath,
  kGlareNoise,
};

/// Random numbers for one kind of error that are the same in all views: what is wrong with the
/// sensor or belongs to the object.
inline RandomStream sensor_stream(std::uint64_t seed, SensorErrorKind kind) {
  return {seed, (static_cast<std::uint64_t>(kind) << 32) + 0xffffffffull};
}

/// What a sensor model may look at while it errs on one view. References outlive the call.
struct SensorScene {
  const SimulationObject& object;
  const PaintedSurface& paint;
  const RangeView& truth;  ///< Exact range, normals and pose. The range is the depth z of a sample.
  int view = 0;            ///< Its index.
  double distance = 0.0;   ///< Working distance: from the sensor to the object's centre [unit].
  double spacing = 0.0;    ///< The side of a pixel at the working distance [unit].
  double diameter = 0.0;   ///< Of the object's sphere [unit].
  std::uint64_t seed = 1;
  double noise_half = 1.0;  ///< Factor of the range noise in the right half of the image, > 0.
  /// Which pixels see a plate behind the object; null: none does.
  const Grid<unsigned char>* background = nullptr;

  /// Factor of the range noise in column u.
  double noise_factor(int u) const { return 2 * u >= truth.width() ? noise_half : 1.0; }
  bool sees_background(int u, int v) const { return background && (*background)(u, v); }
  /// The optical properties of what pixel (u, v) sees; a plate behind the object is white.
  SurfacePaint paint_at(int u, int v, const Eigen::Vector3d& point_in_world) const {
    return sees_background(u, v) ? SurfacePaint{} : paint.at(point_in_world);
  }
  /// The same sensor before what another exact view shows.
  SensorScene seeing(const RangeView& other) const {
    return {object, paint, other, view, distance, spacing, diameter, seed, noise_half, background};
  }

  RandomStream of_view(SensorErrorKind kind) const {
    return {seed, (static_cast<std::uint64_t>(kind) << 32) + static_cast<std::uint64_t>(view)};
  }
  RandomStream of_sensor(SensorErrorKind kind) const { return sensor_stream(seed, kind); }
};

}  // namespace relief::simulation
