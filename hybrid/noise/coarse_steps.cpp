#include "hybrid/noise/coarse_steps.h"

#include <algorithm>
#include <cassert>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

struct Step {
  double expected = 0.0, discrepancy = 0.0, sensitivity = 0.0;
};

// The mean over all samples of a block of the way to the sample `factor` further along the line:
// steps enter by how many of these ways use them. NaN if one is missing.
Step mean_step(const RangeSteps::Direction& direction, int u, int v, int du, int dv, int factor) {
  Step step;
  for (int line = 0; line < factor; ++line) {
    for (int k = 0; k < 2 * factor - 1; ++k) {
      const double share = static_cast<double>(std::min(k + 1, 2 * factor - 1 - k)) /
                           (static_cast<double>(factor) * factor);
      const int eu = u + k * du + line * dv, ev = v + k * dv + line * du;
      step.expected += share * direction.expected(eu, ev);
      step.discrepancy += share * direction.discrepancy(eu, ev);
      step.sensitivity += share * direction.sensitivity(eu, ev);
    }
  }
  return step;
}

RangeSteps::Direction coarse(const RangeSteps::Direction& fine, int du, int dv, int factor) {
  const int width = fine.expected.width() / factor, height = fine.expected.height() / factor;
  const Grid<float> none(width, height, static_cast<float>(kNoSample));
  RangeSteps::Direction result{none, none, none, factor};
  parallel_rows(std::max(0, height - dv), [&](int v) {
    for (int u = 0; u + du < width; ++u) {
      const Step step = mean_step(fine, u * factor, v * factor, du, dv, factor);
      result.expected(u, v) = static_cast<float>(step.expected);
      result.discrepancy(u, v) = static_cast<float>(step.discrepancy);
      result.sensitivity(u, v) = static_cast<float>(step.sensitivity);
    }
  });
  return result;
}

}  // namespace

RangeSteps coarse_steps(const RangeSteps& steps, int factor) {
  assert(steps.along_rows.factor == 1 && factor >= 1);
  return {coarse(steps.along_rows, 1, 0, factor), coarse(steps.along_columns, 0, 1, factor)};
}

}  // namespace relief::hybrid
