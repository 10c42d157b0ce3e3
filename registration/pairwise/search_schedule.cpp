#include "registration/pairwise/search_schedule.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace relief::registration {

namespace {

// A coarse level need not converge further than to this fraction of its search distance: the next
// one searches some 0.4 of it, twenty times as far. Bounds the time, as do the next two: the last
// steps use more samples and determine the precision.
constexpr double kCoarseTolerance = 0.02;
constexpr int kFewestCorrespondences = 200;
constexpr int kHalvings = 2;  // Of the correspondences, towards the coarsest level.

}  // namespace

std::vector<SearchLevel> search_schedule(const SearchScheduleOptions& options) {
  assert(options.levels >= 1 && options.correspondences > 0);
  assert(options.first_distance >= 0.0 && options.last_distance > 0.0);
  const double first = std::max(options.first_distance, options.last_distance);
  const double ratio = options.last_distance / first;
  const int levels = std::max(ratio < 1.0 ? options.levels : 1, options.signal_levels);
  std::vector<SearchLevel> schedule;
  for (int level = 0; level < levels; ++level) {
    const int coarseness = levels - 1 - level;
    SearchLevel next;
    next.count = std::max(options.correspondences >> std::min(coarseness, kHalvings),
                          std::min(kFewestCorrespondences, options.correspondences));
    next.max_distance = coarseness == 0
                            ? options.last_distance
                            : first * std::pow(ratio, level / static_cast<double>(levels - 1));
    next.tolerance = coarseness == 0
                         ? options.tolerance
                         : std::max(options.tolerance, kCoarseTolerance * next.max_distance);
    next.signal_level = std::clamp(coarseness, 0, std::max(0, options.signal_levels - 1));
    schedule.push_back(next);
  }
  return schedule;
}

}  // namespace relief::registration
