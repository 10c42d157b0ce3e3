#pragma once

#include <vector>

#include <Eigen/Core>

#include "registration/pairwise/degenerate_directions.h"
#include "registration/pairwise/icp.h"
#include "registration/pairwise/normal_maps/normal_matches.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Two points that should coincide up to sliding along the surface, in one frame.
struct PlanePair {
  Eigen::Vector3d moving, fixed;
  Eigen::Vector3d moving_normal, fixed_normal;
  /// The normal of whichever point was interpolated on a surface.
  Eigen::Vector3d normal;
  double weight = 1.0;
};

/// Pairs of measured normals that should agree, in the frame of the plane pairs.
struct NormalTerms {
  NormalMatches matches;
  /// What one radian of residual counts for: the ratio of the standard deviations of distances and
  /// normals [unit/rad].
  double length_per_angle = 0.0;
};

/// How firmly the geometry of `pairs` holds a motion.
ConstraintSpectrum analyse_constraints(const std::vector<PlanePair>& pairs);

/// One linearised least-squares step of pairwise alignment.
struct PlaneStep {
  RigidMotion motion = RigidMotion::Identity();  ///< To apply to the moving points.
  ConstraintSpectrum spectrum;
};

/// The motion that minimises the weighted squared distances of `pairs`, (R1) or (R2), and the
/// differences of normals, (R7). Directions whose eigenvalue is below `threshold` are left alone:
/// nothing but noise would move along them.
PlaneStep solve_plane_step(const std::vector<PlanePair>& pairs, const NormalTerms& normals,
                           IcpObjective objective, double threshold);

}  // namespace relief::registration
