#include "scan/simulation/base/plane_waves.h"

#include <cmath>
#include <numbers>

namespace relief::simulation {

PlaneWaves::PlaneWaves(double wavelength, const CounterRandom& random) {
  std::uint64_t draw = 0;
  for (Wave& wave : waves_) {
    const double length = wavelength * (1.0 + random.uniform(draw++));
    wave.phase = 2.0 * std::numbers::pi * random.uniform(draw++);
    wave.vector = 2.0 * std::numbers::pi / length * random_direction(random, draw);
    for (double& a : wave.amplitude) a = random.normal(draw + 3 + (&a - wave.amplitude.data()));
    draw += 6;
  }
}

Eigen::Vector3d PlaneWaves::at(const Eigen::Vector3d& point) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Wave& wave : waves_)
    sum += std::cos(wave.vector.dot(point) + wave.phase) * wave.amplitude;
  return sum;
}

double PlaneWaves::scalar_at(const Eigen::Vector3d& point) const {
  double sum = 0.0;
  for (const Wave& wave : waves_)
    sum += std::cos(wave.vector.dot(point) + wave.phase) * wave.amplitude.x();
  return sum;
}

double PlaneWaves::scalar_variance() const {
  double sum = 0.0;
  for (const Wave& wave : waves_) sum += 0.5 * wave.amplitude.x() * wave.amplitude.x();
  return sum;
}

Eigen::Vector3d random_direction(const CounterRandom& random, std::uint64_t index) {
  return Eigen::Vector3d(random.normal(index), random.normal(index + 1), random.normal(index + 2))
      .normalized();
}

}  // namespace relief::simulation
