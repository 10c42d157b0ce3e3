#include "bench/programs/wavy_view.h"

#include <cmath>
#include <cstdint>

#include "scan/base/counter_random.h"

namespace relief {

RangeView wavy_view(int side) {
  RangeView view;
  view.camera = Camera::orthographic(side, side, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  view.range = Grid<double>(side, side);
  view.normals = Grid<Eigen::Vector3f>(side, side);
  const CounterRandom random(1, 0);
  for (int v = 0; v < side; ++v) {
    for (int u = 0; u < side; ++u) {
      const std::uint64_t i = view.range.index(u, v);
      const double a = 0.06 * u + 0.066 * v, b = 0.31 * u - 0.2 * v, x = 6.28 * u / 256.0;
      const double slope_u = 0.18 * std::cos(a) + 0.12 * std::cos(b) + 0.1 * std::sin(x + 0.01 * v);
      const double slope_v = 0.198 * std::cos(a) - 0.08 * std::cos(b) + 0.1 * std::cos(x);
      view.range(u, v) =
          1000.0 + 3.0 * std::sin(a) + 0.4 * std::sin(b) + kWavyRangeNoise * random.normal(3 * i);
      view.normals(u, v) =
          Eigen::Vector3d(slope_u + kWavyNormalNoise * random.normal(3 * i + 1),
                          slope_v + kWavyNormalNoise * random.normal(3 * i + 2), -1.0)
              .normalized()
              .cast<float>();
    }
  }
  return view;
}

hybrid::ViewWeights wavy_weights(const hybrid::ViewProblem& problem, double sigma_normal,
                                 double sigma_bias_step) {
  hybrid::ViewWeights weights;
  weights.position.assign(problem.grid.size(), 0.0f);
  for (const std::uint32_t i : problem.pixels)
    weights.position[i] = static_cast<float>(1.0 / (kWavyRangeNoise * kWavyRangeNoise));
  for (auto& plane : weights.slope) plane.assign(problem.grid.size(), 0.0f);
  problem.slopes.for_each([&](int axis, std::size_t i) {
    const auto a = static_cast<std::size_t>(axis);
    const double sigma = 2.0 * problem.slopes.axes[a].half_length[i] * sigma_normal;
    weights.slope[a][i] = static_cast<float>(1.0 / (sigma * sigma));
  });
  weights.bias_step.assign(problem.grid.size(), 0.0f);
  for (const std::uint32_t i : problem.pixels)
    weights.bias_step[i] = static_cast<float>(1.0 / sigma_bias_step);
  weights.bias_size = 8.0f;
  return weights;
}

}  // namespace relief
