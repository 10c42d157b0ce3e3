#pragma once

#include <vector>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/estimation/reduced_sum.h"
#include "registration/calibration/estimation/system_layout.h"

namespace relief::registration {

/// A fold of all pairs, the other folds, and the poses that these determine.
struct Fold {
  QuadraticSum own, others;
  EliminatedPoses poses_of_others;
};

/// The problem (C2), linearised where the views are and cut into folds: what both
/// cross-validations start from.
struct FoldSystem {
  SystemLayout layout;
  std::vector<Fold> folds;
  double squares = 0.0;  ///< Of all folds.

  /// `per_view`: whether models may have errors per view. `held` views do not move.
  FoldSystem(const std::vector<PairSums>& pairs, const Sensors& sensors,
             const std::vector<bool>& held, bool per_view);
};

}  // namespace relief::registration
