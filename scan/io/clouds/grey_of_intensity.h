#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "relief/scan/grid.h"

namespace relief {

/// How measured intensities become grey values 0 to 255. Intensities from 0 to 1 are multiplied by
/// 255, whole numbers from 0 to 255 stay, and others go from their least to their largest.
/// Intensities that are all the same say nothing: then `known` is false.
class GreyOfIntensity {
 public:
  void add(double intensity) {
    if (!std::isfinite(intensity)) return;
    least_ = any_ ? std::min(least_, intensity) : intensity;
    largest_ = any_ ? std::max(largest_, intensity) : intensity;
    whole_ = whole_ && intensity == std::floor(intensity);
    any_ = true;
  }

  bool known() const { return any_ && largest_ > least_ && std::isfinite(largest_ - least_); }

  Colour grey(double intensity) const {
    if (!std::isfinite(intensity) || !known()) return {};
    double value = 255.0 * ((intensity - least_) / (largest_ - least_));
    if (least_ >= 0.0 && largest_ <= 1.0) value = 255.0 * intensity;
    if (least_ >= 0.0 && largest_ <= 255.0 && largest_ > 1.0 && whole_) value = intensity;
    const auto level = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
    return {level, level, level};
  }

 private:
  double least_ = 0.0, largest_ = 0.0;
  bool any_ = false, whole_ = true;
};

}  // namespace relief
