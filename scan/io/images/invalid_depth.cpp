#include "scan/io/images/invalid_depth.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace relief {

bool is_largest_of_16_bits(double depth) {
  constexpr double kLargest = 65535.0, kRounding = 1e-6;  // Of 32-bit floats.
  for (double scale = 1.0; scale < 1e5; scale *= 10.0)
    if (std::abs(depth * scale - kLargest) < kRounding * kLargest) return true;
  return false;
}

double invalid_depth_value(std::span<const float> depths) {
  constexpr double kShare = 0.01;    // Of the depths above 0: far beyond chance.
  constexpr double kNearest = 0.25;  // Of the largest value: where other depths may be.
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double largest = 0.0, next = 0.0;
  std::size_t shared = 0, known = 0;
  for (const float depth : depths) {
    const double value = depth;
    if (!(value > 0.0) || !std::isfinite(value)) continue;
    ++known;
    if (value > largest) {
      next = largest;
      largest = value;
      shared = 0;
    }
    if (value == largest)
      ++shared;
    else
      next = std::max(next, value);
  }
  const bool apart = next > 0.0 && (next < kNearest * largest || is_largest_of_16_bits(largest));
  const bool often = static_cast<double>(shared) > kShare * static_cast<double>(known);
  return apart && often && shared > 1 ? largest : kNone;
}

}  // namespace relief
