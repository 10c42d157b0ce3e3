#pragma once

#include <vector>

namespace relief::registration {

/// One level of a coarse-to-fine search.
struct SearchLevel {
  int count = 0;              ///< Correspondences per direction of a pair.
  double max_distance = 0.0;  ///< Between corresponding points [unit].
  double tolerance = 0.0;     ///< The level ends when no point moves more than this [unit].
  int signal_level = 0;       ///< Resolution of the normal maps, 0 the finest.
};

struct SearchScheduleOptions {
  int levels = 3;               ///< >= 1.
  int correspondences = 2000;   ///< At the finest level; half as many at each coarser one. >= 6.
  double first_distance = 0.0;  ///< Of the coarsest level [unit]; at least the last.
  double last_distance = 0.0;   ///< Of the finest [unit]; > 0.
  double tolerance = 0.0;       ///< Of the finest level [unit]; > 0.
  /// Resolutions of the normal maps; more of them than `levels` make as many levels. 0: no maps.
  int signal_levels = 0;
};

/// The search distance of the coarsest level where none is asked for [radii of a view]: what a turn
/// of 11.5 degrees moves the rim by. The bunny returns from 8 (docs/results.md, Registration).
inline constexpr double kFirstSearchRadii = 0.2;

/// The distance [unit] within which corresponding points lie once two views are aligned: a few
/// spacings and standard deviations of the noise.
inline double finest_search_distance(double spacing, double noise) {
  return 4.0 * spacing + 6.0 * noise;
}

/// The RMS of point-to-plane distances [unit] that two views which truly fit stay below: the noise
/// of both (`noise`, combined) and a part of the spacing for what interpolation misses. Wrong poses
/// settle at a spacing or more.
inline double largest_plausible_rms(double spacing, double noise) {
  return 0.15 * spacing + 1.5 * noise;
}

/// Levels from coarse to fine, with distances in geometric progression. A single level where the
/// first distance is not larger than the last and there are no normal maps.
std::vector<SearchLevel> search_schedule(const SearchScheduleOptions& options);

}  // namespace relief::registration
