#pragma once

#include <cstddef>
#include <vector>

#include "registration/surface/view_surface.h"

namespace relief::registration {

/// What the distances between two views deviate by at a relative pose.
struct PairDeviation {
  std::size_t a = 0, b = 0;
  double rms = 0.0;  ///< Of the point-to-plane distances [unit].
};

/// What the better quarter of the pairs deviates by [unit], where that is more than the noise of
/// single samples explains and matters; 0 elsewhere. Sensors that smooth their ranges err by many
/// times that noise. For JudgeOptions::min_stddev.
double common_stddev(const std::vector<ViewSurface>& surfaces,
                     const std::vector<PairDeviation>& pairs);

}  // namespace relief::registration
