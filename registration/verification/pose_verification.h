#pragma once

#include <cstddef>
#include <vector>

#include "registration/posegraph/joint/joint_refinement.h"
#include "registration/surface/view_surface.h"
#include "registration/verification/pose_evidence.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

struct PoseVerificationOptions {
  /// What a pair must show at least; the errors that the views themselves show widen it.
  VerificationThresholds limits;
  Association association = Association::kAuto;
};

/// What the other views say of one view's pose.
struct ViewVerification {
  double support = 0.0;  ///< Sum of overlaps with views that confirm the pose.
  /// Sum of overlaps with views that allow the pose, but do not confirm it. They fit but for stray
  /// samples, or for a misfit that neighbouring samples share: the pose may be wrong by it, or the
  /// calibrations of the sensors. Or they fit on one plane alone.
  double weak_support = 0.0;
  /// Views that it fits as poses are believed that are found by shape, but for what stands in space
  /// seen empty: that may be what moved between two scans. Empty where most of its overlap, that
  /// does not lie on one plane, does not fit so.
  std::vector<std::size_t> fits_in_part_with;
  /// Sum over views that contradict the pose of the fraction of samples in space seen empty.
  double violation = 0.0;
  bool overlaps = false;  ///< Whether any view overlaps it at all.
  /// Whether all of its pairs deviate by more than any pair of the others does, and by more than
  /// twice as much as these typically do, each against its own noise and spacing. A sensor's errors
  /// are in all of its views: these are in one alone, or its pose is wrong.
  bool deviates_alone = false;
  /// Whether views fall into groups, of which it is in a smaller one, such that all pairs between
  /// groups deviate by more than any pair within one does, and by more than twice as much as these
  /// typically do: a rigid object gives no such groups. Images of one may be mirrored.
  bool deviates_with_group = false;
  bool refuted = false;  ///< Whether more speaks against the pose than for it.
};

struct PoseVerification {
  std::vector<ViewVerification> views;
  /// For each view the smallest index of a view that pairs which confirm each other link it to;
  /// excluded and refuted views stand alone.
  std::vector<std::size_t> group;
};

/// Judges refined poses of many views against each other. A pair confirms its pose when it deviates
/// by no more than `limits` and than the better half of all pairs of these views do: calibration
/// errors and correlated noise of a sensor are in all of its pairs. A pair contradicts its pose
/// when one view stands in space that the other saw empty (free-space violation, Huber and Hebert
/// 2003) by more than stray samples. Missing samples prove nothing: sensors with two centres, a
/// laser and a camera, lose what either does not see. Views with more against them than for them
/// are refuted, the worst first, each judged by the others that remain; fixed views never.
PoseVerification verify_poses(const std::vector<ViewSurface>& surfaces,
                              const std::vector<RigidMotion>& world_from_view,
                              const std::vector<ViewRole>& roles,
                              const PoseVerificationOptions& options = {});

}  // namespace relief::registration
