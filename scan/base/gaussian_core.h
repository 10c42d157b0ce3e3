#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace relief {

// The Gaussian core of values with outliers is what lies within a cut of its standard deviation,
// which is the fixed point of the second moment of what the cut leaves.

/// [standard deviations]. A cut of 1.5 has 2.6 times the variance, one of 3 half of it, but takes
/// in more outliers.
inline constexpr double kCoreCut = 2.0;

/// What the cut leaves of the variance: E[z^2 | |z| < 2] of a Gaussian z of variance 1.
inline constexpr double kCoreMoment = 0.77374;

/// Where to start: the smallest positive value among some low quantiles of `values` (all >= 0),
/// with the factor that makes it a standard deviation if they are absolute values of a Gaussian.
/// Low quantiles withstand many outliers; coarsely quantised data needs the higher ones. 0 if all
/// of them are 0. `values`, at least one, are reordered.
template <typename T>
double starting_sigma(std::vector<T>& values) {
  // Of a Gaussian of mean zero: a probability q, and Phi^-1((1 + q) / 2) [standard deviations].
  constexpr std::array<std::pair<double, double>, 4> kQuantiles{
      {{0.10, 0.12566}, {0.25, 0.31864}, {0.50, 0.67449}, {0.90, 1.64485}}};
  for (const auto& [quantile, gaussian] : kQuantiles) {
    const auto place =
        values.begin() + static_cast<std::ptrdiff_t>(quantile * static_cast<double>(values.size()));
    std::nth_element(values.begin(), place, values.end());
    if (*place > T(0)) return *place / gaussian;
  }
  return 0.0;
}

}  // namespace relief
