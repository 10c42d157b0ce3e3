#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "registration/correspondences.h"
#include "registration/view_surface.h"
#include "scan/progress.h"
#include "scan/range_view.h"
#include "scan/result.h"
#include "scan/rigid_motion.h"

namespace relief {

/// What to make of the poses that views come with. Known poses (PoseKind::kKnown) always stay.
enum class GivenPoses {
  kCheck,   ///< Evidence: refined from where they are, kept unless the other views refute them.
  kTrust,   ///< Refined from where they are, and kept whatever the other views say.
  kIgnore,  ///< Not looked at: all poses are found by shape.
};

struct StartingPoseOptions {
  GivenPoses given = GivenPoses::kCheck;
  /// Whether to look by shape for poses that are not given, or not confirmed.
  bool search = true;
  Association association = Association::kAuto;
  /// Two views are linked by shape when they share at least this fraction of their samples; in (0,
  /// 1].
  double min_overlap = 0.15;
  /// At most this fraction of the samples that can be compared may lie in front of what the other
  /// view saw; in [0, 1].
  double max_contradiction = 0.02;
  int threads = 0;  ///< 0: one per core. Never changes the result.
};

/// What is known of the poses before any is looked for by shape.
struct SettledPoses {
  /// Given poses, refined; nothing for views without one and for views whose pose was refuted.
  std::vector<std::optional<RigidMotion>> world_from_view;
  /// For each view the smallest index of a view that confirms its pose, directly or through others.
  std::vector<std::size_t> group;
  std::vector<bool> known;    ///< Exact poses, which do not move.
  std::vector<bool> refuted;  ///< Whether a given pose was refuted.
};

struct StartingPoses {
  /// Nothing where no pose is known.
  std::vector<std::optional<RigidMotion>> world_from_view;
  /// Whether the pose is in one frame with the main group of views.
  std::vector<bool> in_main_frame;
  /// Whether shape gave the pose, not the user.
  std::vector<bool> found_by_shape;
  std::vector<std::string> reasons;  ///< Per view why it has no pose; empty when it has one.
  std::vector<std::string> notes;    ///< One line per pose that was found, for the user to check.
};

/// The poses to start from: the settled ones, and for views outside their main group what
/// place_views() finds by shape. Given poses that nothing confirms stay as they are, in the frame
/// of the others, unless most given poses turn out to be wrong. Views without a pose that fits
/// nowhere, or in more ways than one, get none. Without any given pose the first view of the
/// largest group is the world. A second group that fits together but not with the first is set
/// beside it. The only error is kInterrupted.
Result<StartingPoses> find_starting_poses(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<RangeView>& views,
                                          const SettledPoses& settled,
                                          const StartingPoseOptions& options = {},
                                          const Progress& progress = {});

}  // namespace relief
