#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/estimation/fold_system.h"
#include "registration/calibration/estimation/reduced_sum.h"
#include "registration/calibration/estimation/system_layout.h"
#include "registration/calibration/model/error_model.h"

namespace relief::registration {

/// Cross-validation over views (C4): each group of views in turn is left out of the estimate, with
/// all of its pairs. Errors that views share, estimated without a view, must make this view fit the
/// others better too. So must the errors that the others have apart.
class LeftOutViewsTest {
 public:
  /// `system`: of the same pairs.
  LeftOutViewsTest(const FoldSystem& system, const std::vector<PairSums>& pairs,
                   const Sensors& sensors);

  /// By how much a model lowers the sum of squares of the views left out, for each group of views.
  /// Their poses come from correspondences of other folds. Their own errors per view are 0.
  std::vector<double> gains(const ErrorModel& model) const;

 private:
  struct Group {
    ReducedSum train;          // Of the pairs without any of its views.
    ReducedSum test;           // Of the pairs with at least one.
    ReducedSum common_motion;  // Of the pairs without; empty where views have no errors apart.
  };

  const Sensors& sensors_;
  SystemLayout layout_;
  std::vector<Group> groups_;
};

}  // namespace relief::registration
