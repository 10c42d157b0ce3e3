#pragma once

#include <cstdint>

#include "scan/range_view.h"
#include "scan/simulation/random_stream.h"
#include "scan/simulation/reflectance.h"
#include "scan/simulation/simulation_object.h"

namespace relief {

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
  int threads = 0;

  RandomStream of_view(SensorErrorKind kind) const {
    return {seed, (static_cast<std::uint64_t>(kind) << 32) + static_cast<std::uint64_t>(view)};
  }
  RandomStream of_sensor(SensorErrorKind kind) const { return sensor_stream(seed, kind); }
};

}  // namespace relief
