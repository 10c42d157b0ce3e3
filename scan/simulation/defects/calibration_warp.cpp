#include "scan/simulation/defects/calibration_warp.h"

#include <cmath>
#include <cstddef>

#include "scan/base/counter_random.h"

namespace relief::simulation {

namespace {

// Legendre polynomials of degree 0 to 3 with mean square 1 on [-1, 1].
std::array<double, 4> legendre(double x) {
  return {1.0, std::sqrt(3.0) * x, std::sqrt(5.0) * 0.5 * (3.0 * x * x - 1.0),
          std::sqrt(7.0) * 0.5 * (5.0 * x * x - 3.0) * x};
}

}  // namespace

CalibrationWarp::CalibrationWarp(const RandomStream& stream) {
  const CounterRandom random(stream.seed, stream.stream);
  double squares = 0.0;
  for (int i = 0; i <= kDegree; ++i) {
    for (int j = 0; i + j <= kDegree; ++j) {
      if (i + j == 0) continue;
      const auto k = static_cast<std::size_t>(i * (kDegree + 1) + j);
      coefficients_[k] = random.normal(k);
      squares += coefficients_[k] * coefficients_[k];
    }
  }
  for (double& c : coefficients_) c /= std::sqrt(squares);
}

double CalibrationWarp::at(double x, double y) const {
  const auto px = legendre(x), py = legendre(y);
  double sum = 0.0;
  for (std::size_t i = 0; i <= kDegree; ++i)
    for (std::size_t j = 0; i + j <= kDegree; ++j)
      sum += coefficients_[i * (kDegree + 1) + j] * px[i] * py[j];
  return sum;
}

}  // namespace relief::simulation
