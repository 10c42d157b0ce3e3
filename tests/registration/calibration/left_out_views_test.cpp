#include "registration/calibration/selection/left_out_views.h"

#include <cstddef>
#include <random>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "scan/base/linear_algebra.h"

namespace relief::registration {
namespace {

constexpr std::size_t kViews = 5;
constexpr int kRows = 60;  // Of a pair and a fold.

RangeView view_of(std::size_t index) {
  RangeView view;
  view.camera = Camera::pinhole(20, 20, {60.0, 60.0, 9.5, 9.5});
  view.range = {20, 20, kNoSample};
  for (int v = 0; v < 20; ++v)
    for (int u = 0; u < 20; ++u)
      view.range(u, v) = 100.0 + 0.1 * u * v + static_cast<double>(index);
  return view;
}

// One row of a least-squares problem over the poses of all views and the coefficients of the
// sensor.
struct Row {
  std::size_t source, target, fold;
  Eigen::VectorXd derivative;
  double residual;
};

// Rows of random pairs, as sums and one by one.
struct RandomProblem {
  std::vector<RangeView> views;
  Sensors sensors;
  std::vector<PairSums> pairs;
  std::vector<Row> rows;
  Eigen::Index terms = 0;

  RandomProblem() {
    std::vector<const RangeView*> pointers;
    for (std::size_t i = 0; i < kViews; ++i) views.push_back(view_of(i));
    for (const RangeView& view : views) pointers.push_back(&view);
    sensors = find_sensors(pointers, std::vector<double>(kViews, 1.5));
    terms = static_cast<Eigen::Index>(sensors.models[0].terms());
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (std::size_t source = 0; source < kViews; ++source)
      for (std::size_t target = 0; target < kViews; ++target)
        if (source != target) add_pair(source, target, [&] { return normal(random); });
  }

  template <class Draw>
  void add_pair(std::size_t source, std::size_t target, const Draw& draw) {
    PairSums pair;
    pair.source = source;
    pair.target = target;
    pair.deviation = 1.0;
    for (std::size_t f = 0; f < kFolds; ++f) {
      pair.folds[f] = QuadraticSum(6 + 2 * terms);
      for (int k = 0; k < kRows; ++k) {
        Eigen::VectorXd j(6 + 2 * terms);
        for (double& value : j) value = draw();
        const double residual = draw() + 0.3 * (j[6] + j[6 + terms]);
        pair.folds[f].matrix += j * j.transpose();
        pair.folds[f].gradient += residual * j;
        pair.folds[f].squares += residual * residual;
        rows.push_back({source, target, f, by_all(source, target, j), residual});
      }
    }
    pairs.push_back(std::move(pair));
  }

  LeftOutViewsTest left_out_views(const std::vector<bool>& held, bool per_view) const {
    return {FoldSystem(pairs, sensors, held, per_view), pairs, sensors};
  }

  // The first view is held.
  Eigen::VectorXd by_all(std::size_t source, std::size_t target, const Eigen::VectorXd& j) const {
    Eigen::VectorXd all = Eigen::VectorXd::Zero(6 * kViews + terms);
    all.segment(6 * static_cast<Eigen::Index>(source), 6) += j.head(6);
    all.segment(6 * static_cast<Eigen::Index>(target), 6) -= j.head(6);
    all.head(6).setZero();
    all.tail(terms) = j.segment(6, terms) + j.tail(terms);
    return all;
  }

  // The unknowns that minimise the rows that `use` takes; unknowns without `free` are 0, and the
  // residuals are those at `at`.
  template <class Use>
  Eigen::VectorXd minimum(const Use& use, const std::vector<bool>& free, const Eigen::VectorXd& at,
                          double prior) const {
    const Eigen::Index size = at.size();
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    for (const Row& row : rows) {
      if (!use(row)) continue;
      matrix += row.derivative * row.derivative.transpose();
      gradient += (row.residual + row.derivative.dot(at)) * row.derivative;
    }
    matrix.diagonal().tail(terms).array() += prior;
    for (Eigen::Index i = 0; i < size; ++i) {
      if (!free[static_cast<std::size_t>(i)]) {
        matrix.row(i).setZero();
        matrix.col(i).setZero();
        gradient[i] = 0.0;
      }
      if (matrix(i, i) == 0.0) matrix(i, i) = 1.0;
    }
    return at - solve_symmetric(matrix, gradient);
  }

  template <class Use>
  double squares(const Use& use, const Eigen::VectorXd& at) const {
    double sum = 0.0;
    for (const Row& row : rows) {
      const double residual = row.residual + row.derivative.dot(at);
      if (use(row)) sum += residual * residual;
    }
    return sum;
  }
};

// (C4) by solving for each view and each fold anew.
TEST(LeftOutViews, GainAsWhenEachIsLeftOut) {
  const RandomProblem problem;
  std::vector<bool> held(kViews, false);
  held[0] = true;
  ErrorModel model;
  model.prior_deviation = 0.2;
  model.add({SensorError::kRangeOffset, false}, problem.sensors);
  ASSERT_EQ(model.parameters.size(), 1u);

  const Eigen::Index size = 6 * kViews + problem.terms;
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size);
  std::vector<bool> poses(static_cast<std::size_t>(size), false), all = poses;
  for (std::size_t i = 0; i < 6 * kViews; ++i) poses[i] = all[i] = true;
  const std::size_t offset = 6 * kViews + model.parameters[0].term;
  all[offset] = true;

  const auto gains = problem.left_out_views(held, false).gains(model);
  ASSERT_EQ(gains.size(), kViews);
  for (std::size_t view = 0; view < kViews; ++view) {
    const auto touches = [&](const Row& row) { return row.source == view || row.target == view; };
    const Eigen::VectorXd found =
        problem.minimum([&](const Row& row) { return !touches(row); }, all, zero, model.prior());
    Eigen::VectorXd corrected = zero;
    corrected[static_cast<Eigen::Index>(offset)] = found[static_cast<Eigen::Index>(offset)];
    double gain = 0.0;
    for (std::size_t f = 0; f < kFolds; ++f) {
      const auto others = [&](const Row& row) { return row.fold != f; };
      const auto test = [&](const Row& row) { return row.fold == f && touches(row); };
      gain += problem.squares(test, problem.minimum(others, poses, zero, 0.0)) -
              problem.squares(test, problem.minimum(others, poses, corrected, 0.0));
    }
    EXPECT_NEAR(gains[view], 0.5 * gain, 1e-6 * gain) << view;
    EXPECT_GT(gain, 0.0) << view;
  }
}

// Errors of other views are known without a view, its own are not.
TEST(LeftOutViews, GainByTheErrorsOfTheOthers) {
  const RandomProblem problem;
  const std::vector<bool> held(kViews, false);
  ErrorModel model;
  model.add({SensorError::kRangeOffset, true}, problem.sensors);
  for (const double gain : problem.left_out_views(held, true).gains(model)) EXPECT_GT(gain, 0.0);
}

}  // namespace
}  // namespace relief::registration
