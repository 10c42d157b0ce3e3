#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "registration/given_poses/checked_poses.h"
#include "registration/surface/view_surface.h"
#include "registration/units/align_units.h"
#include "relief/registration/align_options.h"
#include "relief/registration/search_pairs.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Where refining starts. By view.
struct StartingPoses {
  /// Nothing where no pose is known.
  std::vector<std::optional<RigidMotion>> world_from_view;
  /// Which frame the pose is in: 0 that of the main group of views, others those of groups that
  /// were set beside it.
  std::vector<std::size_t> frame;
  /// Whether shape gave the pose, not the user.
  std::vector<bool> found_by_shape;
  /// Whether it is a given pose that stays to the bit (CheckedPoses::kept).
  std::vector<bool> kept;
  std::vector<bool> laid_on_plane;   ///< Whether it is one of CheckedPoses::laid_on_plane.
  std::vector<std::string> reasons;  ///< Per view why it has no pose; empty when it has one.
  std::vector<std::string> notes;    ///< One line per pose that was found, for the user to check.
};

/// The poses to start from: the checked ones, and for views outside their main group what
/// register_globally() finds by shape. Given poses that nothing confirms stay as they are, in the
/// frame of the others, unless most given poses turn out to be wrong. Views without a pose that
/// fits nowhere, or in more ways than one, get none. Without any given pose the first view of the
/// largest group is the world. A second group that fits together but not with the first is set
/// beside it. The only error is kInterrupted.
Result<StartingPoses> find_starting_poses(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<RangeView>& views,
                                          const CheckedPoses& checked,
                                          const StartingPoseOptions& options = {},
                                          const Progress& progress = {},
                                          const AlignUnits& units = {});

/// registration::search_pairs, once given poses are checked.
Result<std::size_t> search_first_pairs(const std::vector<ViewSurface>& surfaces,
                                       const CheckedPoses& checked,
                                       const StartingPoseOptions& options, const PairBlock& block,
                                       const Progress& progress, const AlignUnits& units);

}  // namespace relief::registration
