#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/estimation/fold_system.h"
#include "registration/calibration/estimation/reduced_sum.h"
#include "registration/calibration/estimation/system_layout.h"
#include "registration/calibration/model/error_model.h"

namespace relief::registration {

/// What a model does to the correspondences of each fold, when the other folds determine its
/// parameters and the poses.
struct HeldOutFit {
  std::array<double, kFolds> gain{};         ///< By how much the sum of squares falls.
  std::array<Eigen::VectorXd, kFolds> step;  ///< Of the parameters.
};

/// Standard errors by which the gain of the five folds must exceed 0: Student's t of four degrees
/// of freedom lies beyond with a probability of 0.005. There are two dozen candidates.
inline constexpr double kLeastGain = 4.6;

/// What held-out correspondences gain by an error: the part by which their sum of squares falls,
/// and its standard error over the folds.
struct HeldOutGain {
  double gain = 0.0, deviation = 0.0;

  bool is_beyond_chance() const { return gain > kLeastGain * deviation; }  ///< False for NaN.
};

/// The sum of the gains of all parts, relative to `squares`.
HeldOutGain sum_of_gains(std::span<const double> parts, double squares);

/// Standard deviations of the parameters, by leaving out one fold after the other (Efron 1982).
std::vector<double> jackknife_deviations(const HeldOutFit& fit);

/// The precision of the parameters before any correspondence is known: their prior, and the common
/// motion of those that views have apart (C2), a sum by the coefficients.
Eigen::MatrixXd prior_of(const ErrorModel& model,
                         std::vector<std::vector<Eigen::Index>> coefficients,
                         const ReducedSum& common_motion);

/// Cross-validation of error models. The residuals are linearised once, and the poses eliminated
/// once for each fold. So a model costs the solution of one small system for each fold.
class HeldOutTest {
 public:
  /// `system`: of the same pairs.
  HeldOutTest(const FoldSystem& system, const std::vector<PairSums>& pairs, const Sensors& sensors);

  HeldOutFit fit(const ErrorModel& model) const;

  bool per_view() const { return layout_.per_view; }
  /// The sum of squares of all folds without any error.
  double squares() const { return squares_; }

 private:
  struct ReducedFold {
    ReducedSum train, test;
  };
  const Sensors& sensors_;
  SystemLayout layout_;
  std::array<ReducedFold, kFolds> folds_;
  ReducedSum common_motion_;  // Of errors per view; empty where there may be none.
  double squares_ = 0.0;
};

}  // namespace relief::registration
