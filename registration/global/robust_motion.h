#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// A rigid motion between two sets of points of which many do not belong together.
struct RobustMotion {
  RigidMotion target_from_source = RigidMotion::Identity();
  std::vector<std::size_t> inliers;  ///< Columns that it explains, ascending.
};

/// Minimises the truncated squares (R14), min(|target - motion source|^2, tolerance^2) by graduated
/// non-convexity (Yang et al. 2020): no starting motion, up to three quarters of the columns may be
/// wrong. `tolerance` > 0 [unit]. Fewer than three inliers mean that no motion was found.
RobustMotion fit_robustly(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target,
                          double tolerance);

}  // namespace relief::registration
