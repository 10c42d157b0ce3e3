#pragma once

#include <vector>

#include <Eigen/Core>

#include "registration/posegraph/dense/cluster_scores.h"
#include "registration/posegraph/dense/pair_information.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The normal equations of all poses: a graph whose nodes are views and whose edges carry the 6x6
/// information of pairs (R11). With all tangents about one centre its matrix is a block Laplacian,
/// so nothing in it prefers a view, and any view may be held.
class PoseGraphSystem {
 public:
  /// `held` views do not move. `centre`: that of the pairs' tangents, world frame.
  PoseGraphSystem(const std::vector<const ViewSurface*>& surfaces,
                  const std::vector<PairInformation>& pairs, const std::vector<bool>& held,
                  const Eigen::Vector3d& centre);

  /// The Gauss-Newton step of every view, a tangent about the centre; zero for held views.
  std::vector<RigidTangent> step() const;

  /// What the pull of all pairs changes by along `tangents`, relative to what the information says:
  /// 1 for least squares with fixed correspondences, less with robust weights and renewed ones.
  /// `moved`: the pairs at poses moved by `tangents`.
  double step_gain(const std::vector<PairInformation>& moved,
                   const std::vector<RigidTangent>& tangents) const;

  /// Steps of one standard deviation, were all other views held, in signs that do not repeat.
  std::vector<RigidTangent> random_perturbation() const;

  /// The covariance of all poses (6V x 6V), as tangents (rotation [rad], translation [unit]) about
  /// each view's own centre in world axes; zero rows and columns for held views (R12). Residuals
  /// of one patch of the surface may depend on each other in any way, so a sample that takes part
  /// in many pairs counts once; those of different patches count as independent but for growth().
  /// `pulls`: of the same pairs.
  Eigen::MatrixXd covariance(const std::vector<RigidMotion>& world_from_view,
                             const ClusterScores& scores, double step_gain) const;

  /// By how much the pulls of patches four times as wide vary more than those of independent
  /// patches would; >= 1. About 1.1 for white noise; errors that reach farther, as those of refined
  /// views, give more.
  double variance_inflation(const ClusterScores& scores) const;

 private:
  Eigen::MatrixXd information(double factor) const;
  double spread(const ClusterScores& scores) const;
  Eigen::VectorXd score_of(const std::vector<PairInformation>& pairs) const;
  Eigen::MatrixXd scatter(const ClusterScores& scores) const;

  const std::vector<const ViewSurface*>& surfaces_;
  const std::vector<PairInformation>& pairs_;
  Eigen::Vector3d centre_;
  std::vector<Eigen::Index> free_;   // The rows of views that are not held.
  std::vector<RigidTangent> prior_;  // Precisions: what keeps undetermined poses finite.
};

}  // namespace relief::registration
