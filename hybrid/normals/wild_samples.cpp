#include "hybrid/normals/wild_samples.h"

#include <cmath>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

// Standard deviations of a step, 5 sqrt(2) = 7.1 of the one sample that is wrong: no more than one
// step of the two million of a megapixel is so large by chance (6e-7).
constexpr double kDeviations = 5.0;
constexpr int kFewestSteps = 2;  // One step does not tell which of its samples is wild.

// The steps from one sample to its neighbours, in their standard deviations.
struct StepCount {
  int up = 0, down = 0, all = 0;

  void add(double step, double variance) {
    if (!(step == step)) return;
    ++all;
    if (step * step <= kDeviations * kDeviations * variance) return;
    (step > 0.0 ? up : down) += 1;
  }
  bool wild() const {
    const int needed = all >= 4 ? all - 1 : all;
    return all >= kFewestSteps && (up >= needed || down >= needed);
  }
};

}  // namespace

Grid<std::uint8_t> range_outliers(const RangeSteps& steps, const NoiseEstimate& noise,
                                  const Grid<float>& variance) {
  const int width = steps.along_rows.discrepancy.width();
  const int height = steps.along_rows.discrepancy.height();
  const double range = 2.0 * noise.sigma_local * noise.sigma_local;
  const double slope = noise.sigma_normal * noise.sigma_normal + noise.bias * noise.bias;
  Grid<std::uint8_t> wild(width, height, 0);
  parallel_rows(height, [&](int v) {
    for (int u = 0; u < width; ++u) {
      StepCount count;
      const double here = variance.empty() ? range : range * double{variance(u, v)};
      // From the sample outwards.
      const auto add = [&](const RangeSteps::Direction& direction, int eu, int ev, double sign) {
        if (!direction.discrepancy.contains(eu, ev)) return;
        const double sensitivity = direction.sensitivity(eu, ev);
        count.add(sign * direction.discrepancy(eu, ev), here + sensitivity * sensitivity * slope);
      };
      add(steps.along_rows, u, v, 1.0);
      add(steps.along_rows, u - 1, v, -1.0);
      add(steps.along_columns, u, v, 1.0);
      add(steps.along_columns, u, v - 1, -1.0);
      wild(u, v) = count.wild();
    }
  });
  return wild;
}

}  // namespace relief::hybrid
