#include "registration/calibration/estimation/pose_inflation.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "registration/calibration/estimation/system_sum.h"
#include "scan/base/linear_algebra.h"
#include "tests/registration/calibration/random_pairs.h"

namespace relief::registration {
namespace {

using testing::kViews;
using testing::RandomProblem;

constexpr Eigen::Index kPoses = 6 * (kViews - 1);  // The first view is held.

std::vector<bool> first_held() {
  std::vector<bool> held(kViews, false);
  held[0] = true;
  return held;
}

// The sums of all rows: poses of the views that move, then the coefficients of the sensor.
Eigen::MatrixXd dense_matrix(const RandomProblem& problem) {
  const Eigen::Index size = kPoses + problem.terms;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  for (const testing::Row& row : problem.rows) {
    const Eigen::VectorXd moving = row.derivative.tail(size);
    matrix += moving * moving.transpose();
  }
  return matrix;
}

Eigen::VectorXd variances(const Eigen::MatrixXd& information) {
  return solve_symmetric(information, Eigen::MatrixXd(Eigen::MatrixXd::Identity(
                                          information.rows(), information.cols())))
      .diagonal();
}

// Unknowns of a pair stand in blocks of a sparse matrix; all of them in a dense one say the same.
TEST(PoseInflation, IsThatOfTheDenseInverse) {
  const RandomProblem problem;
  ErrorModel model;
  model.prior_deviation = 0.3;
  model.add({SensorError::kRangeOffset, false}, problem.sensors);
  const auto term = kPoses + static_cast<Eigen::Index>(model.parameters.at(0).term);

  const Eigen::MatrixXd dense = dense_matrix(problem);
  Eigen::MatrixXd with(kPoses + 1, kPoses + 1);
  with << dense.topLeftCorner(kPoses, kPoses), dense.col(term).head(kPoses),
      dense.row(term).head(kPoses), dense(term, term) + model.prior();
  const Eigen::VectorXd of_both = variances(with),
                        of_poses = variances(dense.topLeftCorner(kPoses, kPoses));

  const auto inflation = pose_inflation(problem.pairs, problem.sensors, model, first_held());
  EXPECT_EQ(inflation.at(0), RigidTangent(RigidTangent::Ones()));
  for (Eigen::Index k = 0; k < kPoses; ++k) {
    const double expected = std::sqrt(of_both[k] / of_poses[k]);
    EXPECT_NEAR(inflation.at(static_cast<std::size_t>(1 + k / 6))[k % 6], expected, 1e-9) << k;
  }
}

// Sums of parts are the sum of all.
TEST(SystemSum, OfPartsIsThatOfAllPairs) {
  const RandomProblem problem;
  const SystemLayout layout(problem.sensors, first_held(), false);
  SystemSum all(layout), part(layout), rest(layout);
  for (std::size_t p = 0; p < problem.pairs.size(); ++p) {
    all.add(problem.pairs[p], 0, problem.sensors, layout);
    (p % 3 == 0 ? part : rest).add(problem.pairs[p], 0, problem.sensors, layout);
  }
  part += rest;
  const ReducedSum found = EliminatedPoses(part, layout).reduce(part, layout),
                   expected = EliminatedPoses(all, layout).reduce(all, layout);
  EXPECT_LT((found.matrix - expected.matrix).norm(), 1e-9 * expected.matrix.norm());
  EXPECT_LT((found.gradient - expected.gradient).norm(), 1e-9 * expected.gradient.norm());
}

// Views without any pair have no information, and move nothing.
TEST(SystemSum, OfAViewWithoutPairsIsFinite) {
  const RandomProblem problem;
  const SystemLayout layout(problem.sensors, first_held(), false);
  SystemSum some(layout);
  for (const PairSums& pair : problem.pairs)
    if (pair.source != 2 && pair.target != 2) some.add(pair, 0, problem.sensors, layout);
  const EliminatedPoses poses(some, layout);
  EXPECT_TRUE(poses.slope().allFinite());
  EXPECT_TRUE(poses.slope().middleRows<6>(layout.pose[2]).isZero(0.0));
  EXPECT_TRUE(poses.reduce(some, layout).matrix.allFinite());
}

// Poses that nothing moves leave the sums of the coefficients as they are.
TEST(SystemSum, OfHeldViewsIsThatOfTheCoefficients) {
  const RandomProblem problem;
  const SystemLayout layout(problem.sensors, std::vector<bool>(kViews, true), false);
  SystemSum all(layout);
  for (const PairSums& pair : problem.pairs) all.add(pair, 0, problem.sensors, layout);
  const ReducedSum reduced = EliminatedPoses(all, layout).reduce(all, layout);
  EXPECT_EQ(reduced.matrix, all.coefficients);
  EXPECT_EQ(reduced.gradient, all.coefficient_gradient);
}

}  // namespace
}  // namespace relief::registration
