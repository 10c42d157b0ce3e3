#pragma once

#include <string>
#include <vector>

#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "relief/scan/scan_project.h"

namespace relief::evaluation {

struct PoseErrorOptions {
  /// Whether the two worlds may differ by a rigid motion, which is fitted and taken away first. Off
  /// when a pose is known, so that the worlds are the same by definition.
  bool fit_common_motion = true;
  /// Fit the common motion to the sum over views of their displacements rather than of the squares:
  /// a few views that are far off then hardly move it, and only they are found wrong.
  bool robust = false;
  /// At most so many samples of each view, evenly picked, stand for it. >= 3. Bounds the time.
  std::size_t samples_per_view = 20000;
};

/// How far a view is from its true pose, after the common motion. E below is the motion that takes
/// the true pose to the estimated one.
struct PoseError {
  std::string name;
  double rotation_deg = 0.0;  ///< Angle of E [degrees].
  /// How far E moves the mean of the view's true samples [unit]: unlike the translation of E itself
  /// it does not depend on where the origin is.
  double translation = 0.0;
  double mean_displacement = 0.0;  ///< Mean of how far E moves the view's true samples [unit].
  double rms_displacement = 0.0;   ///< RMS of the same [unit].
};

struct PoseErrorReport {
  std::vector<PoseError> views;  ///< In the order of the result.
  /// Over the views: mean, and largest.
  double mean_rotation_deg = 0.0, max_rotation_deg = 0.0;
  double mean_translation = 0.0, max_translation = 0.0;
  double mean_displacement = 0.0, rms_displacement = 0.0, max_displacement = 0.0;
  /// The common motion that was taken away; the identity when none was fitted.
  RigidMotion truth_from_result = RigidMotion::Identity();
  std::vector<std::string> unmatched;  ///< Views of the truth without a pose in the result.
};

/// Compares the poses of `result` with those of the views of the same names in `truth`, whose
/// samples are used. Views of the result without a pose (kAbsent) are left out and listed as
/// unmatched. kBadInput when a view has no true view or the truth no pose for it, kUnsolvable when
/// no view is left.
Result<PoseErrorReport> evaluate_poses(const ScanProject& result, const ScanProject& truth,
                                       const PoseErrorOptions& options = {});

}  // namespace relief::evaluation
