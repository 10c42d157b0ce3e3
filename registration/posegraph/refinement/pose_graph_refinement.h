#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "registration/pairwise/correspondences.h"
#include "registration/pairwise/normal_maps/normal_matches.h"
#include "registration/posegraph/refinement/pair_information.h"
#include "registration/posegraph/refinement/pose_covariance.h"
#include "registration/posegraph/view_graph.h"
#include "registration/surface/view_surface.h"
#include "relief/registration/align_views.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

struct PoseGraphRefinementOptions {
  /// Of the search; `count` correspondences measure the deviation of each directed pair.
  CorrespondenceOptions search;
  /// Samples of the source, per direction of a pair, at most: of the steps, and of the last one,
  /// which determines the precision. 0: all.
  std::size_t step_samples = 4000, last_samples = 0;
  double tolerance = 0.0;  ///< The last step follows one that moved no sample by more [unit].
  /// Steps before the last one, at most. More than six are taken only as long as they lead on: what
  /// goes to and fro stands as still as renewed correspondences let it.
  int max_iterations = 60;
  /// What the normal maps say of each directed pair at the poses given, (a, b) at 2k, (b, a) at
  /// 2k + 1; empty: nothing.
  NormalMatchesOfPairs normals;
  /// Edge of the patches within which residuals may depend on each other [sample spacings].
  double patch = 8.0;
  /// For two views: relative motions that they do not determine, and that steps leave alone. World
  /// frame.
  std::vector<DegenerateDirection> degenerate_directions;
  /// For each view, motions that steps do not move it by; empty: none of any. World frame.
  MotionsOfViews kept_motions;
};

/// The step that gave the poses, and what it was made of.
struct PoseGraphLastStep {
  std::vector<PairInformation> pairs;  ///< In both directions, at the poses before the step.
  std::vector<RigidTangent> tangents;  ///< What it moved each view by, about `centre`.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Of all tangents, world frame [unit].
  double step_gain = 1.0;                            ///< See PoseGraphSystem::step_gain().
  /// See PoseGraphSystem::variance_inflation(); 1 for patches that are larger already.
  double variance_inflation = 1.0;
};

struct PoseGraphRefinement {
  bool solved = false;  ///< Otherwise the equations are not finite: the poses are as given.
  int iterations = 0;
  double last_motion = 0.0;           ///< Largest motion of a sample before the last step [unit].
  PoseCovariance covariance;          ///< Of all poses: see PoseGraphSystem::covariance().
  std::vector<SolverSummary> solves;  ///< Of all steps.
  PoseGraphLastStep last;
};

/// The last steps of the joint refinement, from nearly right poses: Gauss-Newton on the residuals
/// (R3) of thousands of samples a pair and at last of all, each pair compressed to its 6x6
/// information while its correspondences are found (R11), so that nothing is kept per residual.
/// `held` views do not move.
PoseGraphRefinement refine_pose_graph(const std::vector<const ViewSurface*>& surfaces,
                                      const std::vector<ViewPair>& pairs,
                                      const std::vector<bool>& held,
                                      const PoseGraphRefinementOptions& options,
                                      std::vector<RigidMotion>& world_from_view);

/// The views as refine_pose_graph() takes them.
std::vector<const ViewSurface*> pointers_to(const std::vector<ViewSurface>& surfaces);

/// The largest distance [unit] that a sample moves between two sets of poses, from above.
double largest_motion(const std::vector<const ViewSurface*>& surfaces,
                      const std::vector<RigidMotion>& before,
                      const std::vector<RigidMotion>& after);

}  // namespace relief::registration
