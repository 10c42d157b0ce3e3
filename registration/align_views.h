#pragma once

#include <string>
#include <vector>

#include "registration/joint_refinement.h"
#include "registration/starting_poses.h"
#include "registration/view_surface.h"
#include "scan/progress.h"
#include "scan/range_view.h"
#include "scan/result.h"
#include "scan/rigid_motion.h"

namespace relief {

struct AlignOptions {
  ViewSurfaceOptions surface;
  StartingPoseOptions starting_poses;
  JointRefinementOptions refinement;
  int threads = 0;  ///< 0: one per core; for all steps. Never changes the result.
};

/// What became of one view.
struct ViewReport {
  std::string name;
  RigidMotion world_from_view = RigidMotion::Identity();
  /// Whether the pose is in one frame with the main group of views.
  bool aligned = false;
  /// Covariance of the pose as tangent (rotation [rad], translation [unit]) about the view's centre
  /// in world axes, relative to the held view (R12), and the roots of its diagonal.
  Matrix6d pose_covariance = Matrix6d::Zero();
  RigidTangent pose_std = RigidTangent::Zero();
  std::string reason;  ///< Why it is not aligned; empty when it is.
};

struct Alignment {
  std::vector<ViewReport> views;  ///< In the order given.
  std::vector<PairFit> pairs;     ///< Of all overlapping pairs.
  RefinementTermination termination = RefinementTermination::kNoOverlap;
  int iterations = 0;              ///< Renewals of the correspondences.
  double rms = 0.0;                ///< Of all point-to-plane distances [unit].
  std::vector<std::string> notes;  ///< What the user should know, one line each.

  /// Whether all views are in one frame.
  bool complete() const;
  std::vector<RigidMotion> world_from_view() const;
};

/// Brings range views into one frame: starting poses where none are given, then joint refinement.
/// Known poses are kept to the bit; else the first view of the largest group of overlapping views
/// stays where it is. Views that overlap no others, or fit none, are reported, never forced, and
/// keep their pose. Errors: kBadInput for no views or impossible options, kInterrupted.
Result<Alignment> align_views(const std::vector<RangeView>& views, const AlignOptions& options = {},
                              const Progress& progress = {});

}  // namespace relief
