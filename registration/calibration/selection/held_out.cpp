#include "registration/calibration/selection/held_out.h"

#include <algorithm>
#include <cmath>

#include "scan/base/linear_algebra.h"
#include "scan/base/parallel.h"

namespace relief::registration {

Eigen::MatrixXd prior_of(const ErrorModel& model,
                         std::vector<std::vector<Eigen::Index>> coefficients,
                         const ReducedSum& common_motion) {
  const auto size = static_cast<Eigen::Index>(coefficients.size());
  Eigen::MatrixXd prior = model.prior() * Eigen::MatrixXd::Identity(size, size);
  if (common_motion.gradient.size() == 0) return prior;
  for (std::size_t p = 0; p < coefficients.size(); ++p)
    if (!model.choices[model.parameters[p].choice].per_view) coefficients[p].clear();
  return prior + common_motion.by_parameters(coefficients).matrix;
}

HeldOutTest::HeldOutTest(const FoldSystem& system, const std::vector<PairSums>& pairs,
                         const Sensors& sensors)
    : sensors_(sensors), layout_(system.layout), squares_(system.squares) {
  if (per_view()) {
    common_motion_ = ReducedSum(layout_.coefficients);
    for (const PairSums& pair : pairs) add_common_motion(pair, sensors, layout_, common_motion_);
  }
  parallel_for(kFolds, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f)
      folds_[f] = {system.folds[f].train(layout_), system.folds[f].test(layout_)};
  });
}

HeldOutFit HeldOutTest::fit(const ErrorModel& model) const {
  HeldOutFit fit;
  const auto coefficients = layout_.coefficients_of(model, sensors_);
  if (coefficients.empty()) return fit;
  Eigen::VectorXd values(static_cast<Eigen::Index>(coefficients.size()));
  for (std::size_t p = 0; p < coefficients.size(); ++p)
    values[static_cast<Eigen::Index>(p)] = model.parameters[p].value;
  const Eigen::MatrixXd prior = prior_of(model, coefficients, common_motion_);
  parallel_for(kFolds, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      ReducedSum train = folds_[f].train.by_parameters(coefficients);
      const ReducedSum test = folds_[f].test.by_parameters(coefficients);
      train.matrix += prior;
      train.gradient += prior * values;
      fit.step[f] = -solve_symmetric(train.matrix, train.gradient);
      fit.gain[f] = test.fall(fit.step[f]);
    }
  });
  return fit;
}

HeldOutGain sum_of_gains(std::span<const double> parts, double squares) {
  HeldOutGain result;
  double sum_of_squares = 0.0;
  for (const double part : parts) {
    result.gain += part / squares;
    sum_of_squares += part / squares * (part / squares);
  }
  const auto count = static_cast<double>(parts.size());
  const double variance =
      std::max(0.0, sum_of_squares - result.gain * result.gain / count) / (count - 1.0);
  result.deviation = std::sqrt(count * variance);
  return result;
}

std::vector<double> jackknife_deviations(const HeldOutFit& fit) {
  constexpr auto kCount = static_cast<double>(kFolds);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(fit.step[0].size());
  for (const Eigen::VectorXd& step : fit.step) mean += step / kCount;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(mean.size());
  for (const Eigen::VectorXd& step : fit.step) squares += (step - mean).cwiseAbs2();
  const Eigen::VectorXd deviations = (squares * (kCount - 1.0) / kCount).cwiseSqrt();
  return {deviations.data(), deviations.data() + deviations.size()};
}

}  // namespace relief::registration
