#pragma once

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

enum class CoarseSearch {
  kAuto,    ///< Given poses are tried; views that they do not place are searched for by shape.
  kNever,   ///< Given poses are taken as they are; views without one are only tried in the order of
            ///< scans from a turntable.
  kAlways,  ///< By shape alone; only known poses count.
};

struct StartingPoseOptions {
  CoarseSearch coarse = CoarseSearch::kAuto;
  Association association = Association::kAuto;
  /// Two views are linked by shape when they share at least this fraction of their samples; in (0,
  /// 1].
  double min_overlap = 0.15;
  /// At most this fraction of the samples that can be compared may lie in front of what the other
  /// view saw; in [0, 1].
  double max_contradiction = 0.02;
  int threads = 0;  ///< 0: one per core. Never changes the result.
};

struct StartingPoses {
  /// Nothing where no pose was given that fits and none was found.
  std::vector<std::optional<RigidMotion>> world_from_view;
  std::vector<std::string> reasons;  ///< Per view why it has no pose; empty when it has one.
  std::vector<std::string> notes;    ///< One line per pose that was found, for the user to check.
};

/// The poses to start from. Given ones that fit other views stay as they are; the other views are
/// placed by shape, by the links of place_views(), relative to them. Views without a pose that fits
/// nowhere, or in more ways than one, get none. Without any given pose the first view of the
/// largest group is the world. A second group that fits together but not with the first is set
/// beside it. The only error is kInterrupted.
Result<StartingPoses> find_starting_poses(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<RangeView>& views,
                                          const StartingPoseOptions& options = {},
                                          const Progress& progress = {});

}  // namespace relief
