#pragma once

#include <cmath>

namespace relief {

// The transfer function of sRGB (IEC 61966-2-1), whose constants these are, and its inverse. Values
// are 0 to 1.
inline double linear_from_srgb(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

inline double srgb_from_linear(double value) {
  return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
}

}  // namespace relief
