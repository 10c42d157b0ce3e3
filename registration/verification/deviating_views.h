#pragma once

#include <cstddef>
#include <vector>

namespace relief::registration {

/// How much two views deviate at their poses, against their own noise and spacing.
struct RelativeDeviation {
  std::size_t a = 0, b = 0;
  double rms = 0.0;  ///< See relative_rms().
};

/// Views that deviate as a sensor's errors do not, which are in all of its pairs.
struct DeviatingViews {
  /// See ViewVerification::deviates_alone.
  std::vector<bool> alone;
  /// See ViewVerification::deviates_with_group.
  std::vector<bool> with_group;
};

/// `deviations`: of pairs of `views` views.
DeviatingViews find_deviating_views(std::size_t views,
                                    const std::vector<RelativeDeviation>& deviations);

}  // namespace relief::registration
