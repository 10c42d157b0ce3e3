#pragma once

#include <array>
#include <vector>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/estimation/reduced_sum.h"
#include "registration/calibration/estimation/system_layout.h"
#include "registration/calibration/estimation/system_sum.h"

namespace relief::registration {

/// The sums of each fold.
using FoldSums = std::array<SystemSum, kFolds>;

FoldSums empty_folds(const SystemLayout& layout);
/// Adds all folds of a pair.
void add_pair(const PairSums& pair, const Sensors& sensors, const SystemLayout& layout,
              FoldSums& folds);

/// A fold of all pairs, the other folds, and the poses that these determine.
struct Fold {
  SystemSum own, others;
  EliminatedPoses poses_of_others;

  /// Functions of the coefficients, with the poses put in.
  ReducedSum train(const SystemLayout& layout) const {
    return poses_of_others.reduce(others, layout);
  }
  ReducedSum test(const SystemLayout& layout) const { return poses_of_others.reduce(own, layout); }
};

/// The problem (C2), linearised where the views are and cut into folds: what both
/// cross-validations start from.
struct FoldSystem {
  SystemLayout layout;
  std::array<Fold, kFolds> folds;
  double squares = 0.0;  ///< Of all folds.

  FoldSystem(SystemLayout layout, FoldSums sums);
};

/// `per_view`: whether models may have errors per view. `held` views do not move.
FoldSystem fold_system(const std::vector<PairSums>& pairs, const Sensors& sensors,
                       const std::vector<bool>& held, bool per_view);

}  // namespace relief::registration
