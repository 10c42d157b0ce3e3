#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "relief/registration/align_options.h"
#include "relief/registration/pair_fit.h"
#include "relief/scan/range_view.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

enum class IcpObjective {
  kPointToPlane,  ///< Chen and Medioni 1991.
  kSymmetric,     ///< Rusinkiewicz 2019: exact on quadrics, converges from farther away.
};

struct IcpOptions {
  IcpObjective objective = IcpObjective::kSymmetric;
  Association association = Association::kAuto;
  /// Correspondences per direction at the finest level; >= 6. Bounds the time.
  int correspondences = 2000;
  /// Samples of either view in the last steps, which determine the precision and give the
  /// covariance; 0: no such steps. >= 0. Bounds the time.
  int final_samples = 8000;
  /// Levels from coarse (few correspondences, wide search) to fine; >= 1.
  int levels = 3;
  /// How far apart corresponding points may be at first [unit]. 0: a fifth of the smaller view's
  /// radius.
  double search_distance = 0.0;
  /// Between corresponding normals [deg]; keeps the two sides of thin sheets apart.
  double max_normal_angle_deg = 40.0;
  /// Align the normal maps too, (R7), where both views have them.
  bool normal_maps = true;
  /// Stop when an iteration moves no point of the source by more than this [sample spacings].
  double tolerance = 0.005;
  int max_iterations = 40;       ///< Per level; bounds the time.
  int min_correspondences = 30;  ///< Both directions together; fewer mean no overlap. >= 6.
};

enum class IcpTermination {
  kConverged,
  kIterationLimit,
  kNoOverlap,  ///< Too few correspondences; the pose is the last one that had enough.
};

struct IcpResult {
  RigidMotion target_from_source = RigidMotion::Identity();
  IcpTermination termination = IcpTermination::kNoOverlap;
  int iterations = 0;  ///< Over all levels.
  std::size_t correspondences = 0;
  double overlap = 0.0;  ///< Fraction of samples seen by the other view, mean of both directions.
  double rms = 0.0;      ///< Of the point-to-plane distances [unit].
  /// Of the pose, for tangents (rotation [rad], translation [unit]) of the motion about
  /// `covariance_centre`, the source's centre (target frame), by (R12): it knows what neighbouring
  /// residuals share and nothing of calibration errors. Along degenerate directions it is huge.
  /// Zero without last steps.
  Matrix6d covariance = Matrix6d::Zero();
  Eigen::Vector3d covariance_centre = Eigen::Vector3d::Zero();
  /// Standard deviation of the differences of the normal maps [rad]; 0 where none were used.
  double normal_sigma = 0.0;
  /// Motions that the shared surface does not determine (target frame). The pose was not moved
  /// along them.
  std::vector<DegenerateDirection> degenerate_directions;

  bool usable() const { return termination != IcpTermination::kNoOverlap; }
};

/// Aligns `source` to `target` from a starting pose: iterated closest points with robust weights,
/// correspondences in both directions, coarse to fine. The poses that the views come with are not
/// looked at. With Association::kProjective both cameras must be able to project
/// (Camera::can_project).
IcpResult align_pair(const RangeView& source, const RangeView& target,
                     const RigidMotion& target_from_source, const IcpOptions& options = {});

/// `converged`, `iteration limit` or `no overlap`.
std::string_view to_string(IcpTermination termination);

}  // namespace relief::registration
