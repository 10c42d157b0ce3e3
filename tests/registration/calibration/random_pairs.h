// Random pairs of views: as sums, and row by row for oracles.
#pragma once

#include <cstddef>
#include <random>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/calibration/model/sensor_model.h"
#include "relief/scan/range_view.h"
#include "scan/base/linear_algebra.h"

namespace relief::testing {

inline constexpr std::size_t kViews = 5;
inline constexpr int kRows = 60;  // Of a pair and a fold.

inline RangeView small_view(std::size_t index) {
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
  registration::Sensors sensors;
  std::vector<registration::PairSums> pairs;
  std::vector<Row> rows;
  Eigen::Index terms = 0;

  RandomProblem() {
    std::vector<const RangeView*> pointers;
    for (std::size_t i = 0; i < kViews; ++i) views.push_back(small_view(i));
    for (const RangeView& view : views) pointers.push_back(&view);
    sensors = registration::find_sensors(pointers, std::vector<double>(kViews, 1.5));
    terms = static_cast<Eigen::Index>(sensors.models[0].terms());
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (std::size_t source = 0; source < kViews; ++source)
      for (std::size_t target = 0; target < kViews; ++target)
        if (source != target) add_pair(source, target, [&] { return normal(random); });
  }

  template <class Draw>
  void add_pair(std::size_t source, std::size_t target, const Draw& draw) {
    registration::PairSums pair;
    pair.source = source;
    pair.target = target;
    pair.deviation = 1.0;
    for (std::size_t f = 0; f < registration::kFolds; ++f) {
      pair.folds[f] = registration::QuadraticSum(6 + 2 * terms);
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

}  // namespace relief::testing
