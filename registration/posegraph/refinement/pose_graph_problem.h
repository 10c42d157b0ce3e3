#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "registration/posegraph/refinement/block_sandwich.h"
#include "registration/posegraph/refinement/pair_information.h"
#include "relief/registration/align_views.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What brings all poses to the least of a quadratic sum.
struct PoseGraphStep {
  std::vector<RigidTangent> tangents;  ///< About the centre of the pairs; zero for held views.
  SolverSummary summary;

  bool usable() const { return summary.termination != SolverTermination::kFailed; }
};

/// What each view may do.
struct AllowedMotions {
  std::vector<RigidTangent> prior;  ///< Precisions of the components of each view's tangent.
  /// For each view the projection of tangents onto the motions that its pairs may move it by. The
  /// prior alone holds the others, and steps do not take them.
  std::vector<Matrix6d> projection;
};

/// The matrix of PoseGraphProblem, held views and all. Not finite if the sums of a pair are not.
SymmetricBlocks information_blocks(const std::vector<PairInformation>& pairs,
                                   const AllowedMotions& allowed, double step_gain);

/// The quadratic sum (R11) over the small motions of all views, as Ceres takes it: a block of six
/// tangent components per view, seven residuals per pair of views (R6), and a prior per view that
/// keeps undetermined motions finite.
class PoseGraphProblem {
 public:
  /// `held` views do not move. `step_gain` scales the information of ranges, not that of normal
  /// maps.
  PoseGraphProblem(const std::vector<PairInformation>& pairs, const AllowedMotions& allowed,
                   const std::vector<bool>& held, double step_gain = 1.0);
  ~PoseGraphProblem();
  PoseGraphProblem(PoseGraphProblem&&) noexcept;
  PoseGraphProblem& operator=(PoseGraphProblem&&) noexcept;

  /// The Gauss-Newton step.
  PoseGraphStep minimise();

  /// Inverts the matrix of the quadratic sum, prior and all. Whether that could be done.
  [[nodiscard]] bool invert();

  /// A block of the inverse, once invert() succeeded; zero where either view is held.
  Matrix6d inverse(std::size_t row, std::size_t column) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace relief::registration
