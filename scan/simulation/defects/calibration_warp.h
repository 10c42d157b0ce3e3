#pragma once

#include <array>

#include "scan/simulation/base/random_stream.h"

namespace relief::simulation {

/// The smooth error that a calibration leaves: a random cubic polynomial of the image coordinates,
/// equation (S9). Its mean over the image is 0 and its RMS 1.
class CalibrationWarp {
 public:
  explicit CalibrationWarp(const RandomStream& random);

  /// `x` and `y` run from -1 to 1 over the image.
  double at(double x, double y) const;

 private:
  static constexpr int kDegree = 3;  // Of (S9).
  std::array<double, (kDegree + 1) * (kDegree + 1)> coefficients_{};
};

/// The image coordinate of pixel `index` of a row or column of `count`: from -1 to 1.
inline double image_coordinate(int index, int count) { return 2.0 * (index + 0.5) / count - 1.0; }

}  // namespace relief::simulation
