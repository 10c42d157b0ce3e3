#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace relief {

/// Turns the median absolute value of Gaussian numbers of mean zero into their standard deviation:
/// 1 / Phi^-1(3/4).
inline constexpr double kSigmaPerMedian = 1.4826;

/// The median of `values`, the upper one of an even number; 0 for none. Reorders them.
template <typename T>
T median(std::vector<T>& values) {
  if (values.empty()) return T(0);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <typename T>
T median(std::vector<T>&& values) {
  return median(values);
}

}  // namespace relief
