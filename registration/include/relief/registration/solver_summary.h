#pragma once

#include <string>
#include <string_view>

namespace relief::registration {

enum class SolverTermination {
  kConverged,
  kIterationLimit,  ///< Usual where correspondences are renewed: few steps are enough then.
  kFailed,          ///< The equations are not finite, or cannot be solved: no pose was moved.
};

/// What a minimisation is about.
enum class SolverStage {
  kJoint,        ///< Correspondences of all pairs, renewed after each solve (R3).
  kPoseGraph,    ///< The quadratic sum over all samples of all pairs (R11).
  kCalibration,  ///< Poses and errors of the sensors together (C2).
};

/// One minimisation over all poses, as the solver sums it up.
struct SolverSummary {
  SolverStage stage = SolverStage::kJoint;
  SolverTermination termination = SolverTermination::kFailed;
  int iterations = 0;  ///< Steps of Levenberg-Marquardt, also those that were rejected.
  /// Half the sum of all losses (R3) before and after; after a pose graph step, as it expects.
  double initial_cost = 0.0, final_cost = 0.0;
  std::string message;  ///< Why it ended, in the solver's words.
  double seconds = 0.0;
};

/// `converged`, `iteration limit` or `failed`.
std::string_view to_string(SolverTermination termination);

/// `joint`, `pose graph` or `calibration`.
std::string_view to_string(SolverStage stage);

}  // namespace relief::registration
