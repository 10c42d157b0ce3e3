#pragma once

#include <array>

#include <Eigen/Core>

#include "scan/base/counter_random.h"

namespace relief::simulation {

/// A smooth random field of vectors in space, equation (S4): the sum of 16 plane waves of random
/// directions, phases and normally distributed amplitudes, their lengths between `wavelength`
/// [unit] and twice that.
class PlaneWaves {
 public:
  PlaneWaves(double wavelength, const CounterRandom& random);

  Eigen::Vector3d at(const Eigen::Vector3d& point) const;
  /// The first component alone.
  double scalar_at(const Eigen::Vector3d& point) const;
  /// The variance of the first component over all space.
  double scalar_variance() const;

 private:
  struct Wave {
    Eigen::Vector3d vector = Eigen::Vector3d::Zero(), amplitude = Eigen::Vector3d::Zero();
    double phase = 0.0;
  };
  std::array<Wave, 16> waves_;
};

/// A random direction, uniform on the sphere, from three of the numbers of `random`.
Eigen::Vector3d random_direction(const CounterRandom& random, std::uint64_t index);

}  // namespace relief::simulation
