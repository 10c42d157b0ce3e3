#pragma once

#include <optional>
#include <string>
#include <vector>

#include "registration/icp.h"
#include "registration/view_surface.h"
#include "scan/progress.h"
#include "scan/range_view.h"
#include "scan/result.h"
#include "scan/rigid_motion.h"

namespace relief {

struct StartingPoseOptions {
  Association association = Association::kAuto;
  /// A hypothesis must make the two views share at least this fraction of their samples; in (0, 1].
  double min_overlap = 0.3;
  /// At most this fraction of the samples may lie in front of what the other view saw; in [0, 1].
  double max_contradiction = 0.1;
  int threads = 0;  ///< 0: one per core. Never changes the result.
};

struct StartingPoses {
  /// Nothing where no pose was given and none was found.
  std::vector<std::optional<RigidMotion>> world_from_view;
  std::vector<std::string> notes;  ///< One line per pose that was found, for the user to check.
};

/// The poses to start from: the given ones, and for views without any, hypotheses from the order of
/// the scans. A view is tried in the pose of its predecessor or successor, by the turn that fitted
/// last, and by turns of the object on a turntable (about axes up to 40 degrees off the sensor's
/// vertical); each is refined by ICP and must explain both views. Without any given pose the first
/// view with samples is the world. The only error is kInterrupted.
Result<StartingPoses> find_starting_poses(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<RangeView>& views,
                                          const StartingPoseOptions& options = {},
                                          const Progress& progress = {});

/// Fraction of the source's samples that would have hidden from the target what it measured: they
/// lie more than `margin` [unit] in front of its surface (Huber and Hebert 2003). 0 where the
/// target cannot project.
double contradiction(const ViewSurface& source, const ViewSurface& target,
                     const RigidMotion& target_from_source, double margin);

}  // namespace relief
