#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/estimation/reduced_sum.h"
#include "registration/calibration/model/error_model.h"

namespace relief::registration {

/// Where the unknowns of a calibration stand in one vector: the poses of the views that move, then
/// the coefficients of all terms, of each view or of each sensor.
struct SystemLayout {
  std::vector<Eigen::Index> pose;   ///< Of each view; -1: it is held.
  std::vector<Eigen::Index> terms;  ///< Of each view, counted from the first coefficient.
  Eigen::Index poses = 0, coefficients = 0;
  bool per_view = false;

  SystemLayout(const Sensors& sensors, const std::vector<bool>& held, bool per_view);

  /// The coefficients that a parameter of a model adds to.
  std::vector<Eigen::Index> coefficients_of(const ErrorModel& model,
                                            const ErrorParameter& parameter,
                                            const Sensors& sensors) const;
};

/// The sums of one fold over all pairs.
QuadraticSum sum_of_fold(const std::vector<PairSums>& pairs, std::size_t fold,
                         const Sensors& sensors, const SystemLayout& layout);

/// Adds those of one pair.
void add_fold(const PairSums& pair, std::size_t fold, const Sensors& sensors,
              const SystemLayout& layout, QuadraticSum& all);

/// Adds the common_motion() of a pair, by the coefficients. It has no gradient.
void add_common_motion(const PairSums& pair, const Sensors& sensors, const SystemLayout& layout,
                       ReducedSum& all);

}  // namespace relief::registration
