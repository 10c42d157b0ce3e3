#include "registration/calibration/selection/held_out.h"

#include <Eigen/Cholesky>

#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// What keeps poses finite that nothing determines, relative to the precision of a component: far
// above rounding (2e-16) and below all evidence.
constexpr double kRelativePrior = 1e-12;

}  // namespace

HeldOutTest::EliminatedPoses::EliminatedPoses(const QuadraticSum& sum, Eigen::Index poses) {
  const Eigen::Index coefficients = sum.gradient.size() - poses;
  Eigen::MatrixXd matrix = sum.matrix.topLeftCorner(poses, poses);
  matrix.diagonal() *= 1.0 + kRelativePrior;
  matrix.diagonal().array() += 1e-300;
  const Eigen::LDLT<Eigen::MatrixXd> factor(matrix);
  offset = -factor.solve(sum.gradient.head(poses));
  slope = -factor.solve(sum.matrix.topRightCorner(poses, coefficients));
}

// A sum with the poses put in.
HeldOutTest::ReducedSum HeldOutTest::EliminatedPoses::reduce(const QuadraticSum& sum) const {
  const Eigen::Index poses = offset.size(), coefficients = slope.cols();
  const auto pp = sum.matrix.topLeftCorner(poses, poses);
  const auto pc = sum.matrix.topRightCorner(poses, coefficients);
  const Eigen::MatrixXd half = pp * slope + pc;
  const Eigen::MatrixXd cross = slope.transpose() * pc;
  ReducedSum reduced;
  reduced.matrix = slope.transpose() * half + cross.transpose() +
                   sum.matrix.bottomRightCorner(coefficients, coefficients);
  reduced.gradient = sum.gradient.tail(coefficients) +
                     slope.transpose() * sum.gradient.head(poses) + half.transpose() * offset;
  return reduced;
}

HeldOutTest::HeldOutTest(const std::vector<PairSums>& pairs, const Sensors& sensors,
                         const std::vector<bool>& held, bool per_view)
    : sensors_(sensors), layout_(sensors, held, per_view) {
  auto sums = parallel_map<QuadraticSum>(
      kFolds, [&](std::size_t f) { return sum_of_fold(pairs, f, sensors, layout_); });
  QuadraticSum all(layout_.poses + layout_.coefficients);
  for (const QuadraticSum& sum : sums) all += sum;
  squares_ = all.squares;
  if (per_view) common_motion_ = common_motion_of(pairs, sensors, layout_);
  parallel_for(kFolds, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      QuadraticSum train = all;
      train.matrix -= sums[f].matrix;
      train.gradient -= sums[f].gradient;
      const EliminatedPoses poses(train, layout_.poses);
      folds_[f] = {poses.reduce(train), poses.reduce(sums[f])};
    }
  });
}

HeldOutTest::ReducedSum HeldOutTest::by_parameters(
    const ReducedSum& sum, const std::vector<std::vector<Eigen::Index>>& coefficients) {
  const auto count = static_cast<Eigen::Index>(coefficients.size());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(sum.matrix.rows(), count);
  ReducedSum result{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count)};
  for (Eigen::Index p = 0; p < count; ++p) {
    for (const Eigen::Index c : coefficients[static_cast<std::size_t>(p)]) {
      columns.col(p) += sum.matrix.col(c);
      result.gradient[p] += sum.gradient[c];
    }
  }
  for (Eigen::Index p = 0; p < count; ++p)
    for (const Eigen::Index c : coefficients[static_cast<std::size_t>(p)])
      result.matrix.row(p) += columns.row(c);
  return result;
}

HeldOutFit HeldOutTest::fit(const ErrorModel& model) const {
  std::vector<std::vector<Eigen::Index>> coefficients;
  Eigen::VectorXd values(static_cast<Eigen::Index>(model.parameters.size()));
  for (const ErrorParameter& parameter : model.parameters) {
    values[static_cast<Eigen::Index>(coefficients.size())] = parameter.value;
    coefficients.push_back(layout_.coefficients_of(model, parameter, sensors_));
  }
  HeldOutFit fit;
  if (coefficients.empty()) return fit;
  Eigen::MatrixXd prior = model.prior() * Eigen::MatrixXd::Identity(values.size(), values.size());
  if (per_view()) {
    std::vector<std::vector<Eigen::Index>> apart = coefficients;
    for (std::size_t p = 0; p < apart.size(); ++p)
      if (!model.choices[model.parameters[p].choice].per_view) apart[p].clear();
    prior +=
        by_parameters({common_motion_, Eigen::VectorXd::Zero(layout_.coefficients)}, apart).matrix;
  }
  parallel_for(kFolds, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      ReducedSum train = by_parameters(folds_[f].train, coefficients);
      const ReducedSum test = by_parameters(folds_[f].test, coefficients);
      train.matrix += prior;
      train.gradient += prior * values;
      fit.step[f] = -Eigen::LDLT<Eigen::MatrixXd>(train.matrix).solve(train.gradient);
      fit.gain[f] = -fit.step[f].dot(test.matrix * fit.step[f] + 2.0 * test.gradient);
    }
  });
  return fit;
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
