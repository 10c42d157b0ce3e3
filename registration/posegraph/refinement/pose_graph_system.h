#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "registration/posegraph/refinement/cluster_scores.h"
#include "registration/posegraph/refinement/pair_information.h"
#include "registration/posegraph/refinement/pose_covariance.h"
#include "registration/posegraph/refinement/pose_graph_problem.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The normal equations of all poses: a graph whose nodes are views and whose edges carry the 6x6
/// information of pairs (R11). With all tangents about one centre its matrix is a block Laplacian,
/// so nothing in it prefers a view, and any view may be held.
class PoseGraphSystem {
 public:
  /// `held` views do not move. `centre`: that of the pairs' tangents, world frame. `projection`:
  /// see AllowedMotions; empty: all motions.
  PoseGraphSystem(const std::vector<const ViewSurface*>& surfaces,
                  const std::vector<PairInformation>& pairs, const std::vector<bool>& held,
                  const Eigen::Vector3d& centre, std::vector<Matrix6d> projection = {});

  /// The Gauss-Newton step of every view.
  PoseGraphStep step() const;

  /// How much of a Gauss-Newton step the score follows: the change of the score along `tangents`
  /// over the change that the information matrix predicts. The step gain is 1 for least squares
  /// with fixed correspondences. Robust weights and renewed correspondences make it smaller.
  /// `moved`: the pairs at poses moved by `tangents`.
  double step_gain(const std::vector<PairInformation>& moved,
                   const std::vector<RigidTangent>& tangents) const;

  /// A pseudo-random perturbation to measure the step gain with: each component is plus or minus
  /// one standard deviation of the pose with all other views held.
  std::vector<RigidTangent> random_perturbation() const;

  /// The covariance of all poses; zero for held views (R12). Residuals of one cluster may depend on
  /// each other in any way, so a sample that takes part in many pairs counts once. Those of
  /// different clusters count as independent, up to `inflation`. `scores`: of the same pairs,
  /// `inflation`: their variance_inflation(). Nothing if the equations are not finite.
  std::optional<PoseCovariance> covariance(const std::vector<RigidMotion>& world_from_view,
                                           const ClusterScores& scores, double inflation,
                                           double step_gain) const;

  /// The variance of the scores of clusters four times as wide over that of independent clusters;
  /// >= 1. About 1.1 for white noise. Errors of longer range, as those of refined views, give more.
  double variance_inflation(const ClusterScores& scores) const;

 private:
  std::vector<Matrix6d> information_of_views() const;
  double spread(const ClusterScores& scores) const;
  SymmetricBlocks scatter(const ClusterScores& scores, double inflation) const;

  const std::vector<const ViewSurface*>& surfaces_;
  const std::vector<PairInformation>& pairs_;
  std::vector<bool> held_;
  Eigen::Vector3d centre_;
  AllowedMotions allowed_;
};

}  // namespace relief::registration
