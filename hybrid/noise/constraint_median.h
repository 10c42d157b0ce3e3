#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "hybrid/model/view_problem.h"
#include "scan/base/median.h"

namespace relief::hybrid {

/// The median of `value(axis, i)` over the slope constraints of `problem`; of many, only so many
/// that it is good to about a percent.
template <typename Value>
double median_over_constraints(const ViewProblem& problem, const Value& value) {
  const std::size_t stride = std::max<std::size_t>(1, problem.constraints / 100000);
  std::vector<float> values;
  std::size_t k = 0;
  problem.slopes.for_each([&](int axis, std::size_t i) {
    if (k++ % stride == 0) values.push_back(value(static_cast<std::size_t>(axis), i));
  });
  return median(std::move(values));
}

}  // namespace relief::hybrid
