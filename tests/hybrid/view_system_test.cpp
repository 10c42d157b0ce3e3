#include "hybrid/view_system.h"

#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "tests/hybrid/bumpy_view.h"

namespace relief {
namespace {

// A small view with a hole, an occlusion and a patch without normals.
RangeView ragged_view() {
  RangeView view = testing::render(testing::bumpy_surface(), testing::bumpy_camera(7, 6));
  testing::add_range_noise(view, 0.2, 1);
  testing::add_normal_noise(view, 0.1, 2);
  view.range(2, 3) = kNoSample;
  for (int v = 0; v < 6; ++v) view.range(6, v) += 40.0;
  view.normals(4, 4).setConstant(static_cast<float>(kNoSample));
  return view;
}

Eigen::VectorXd random_vector(Eigen::Index size, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(0.5, 1.5);
  Eigen::VectorXd values(size);
  for (double& value : values) value = uniform(generator);
  return values;
}

ViewWeights random_weights(const ViewProblem& problem, std::uint32_t seed) {
  return {random_vector(static_cast<Eigen::Index>(problem.size()), seed).cast<float>(),
          random_vector(static_cast<Eigen::Index>(problem.slopes.size()), seed + 1).cast<float>(),
          0.7f + static_cast<float>(seed), 0.2f};
}

// The objective (7a) written down from the definition of its residuals.
double objective(const ViewProblem& problem, const ViewWeights& weights, const Eigen::VectorXd& y,
                 bool with_bias) {
  const auto n = static_cast<Eigen::Index>(problem.size());
  double sum = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) sum += weights.position[i] * y[i] * y[i];
  for (std::size_t k = 0; k < problem.slopes.size(); ++k) {
    const SlopeConstraint& c = problem.slopes[k];
    double residual =
        double{c.step} + double{c.head_slope} * y[c.head] - double{c.tail_slope} * y[c.tail];
    const Eigen::Index bias = (1 + c.axis) * n;
    if (with_bias) residual -= double{c.length} * 0.5 * (y[bias + c.at[0]] + y[bias + c.at[1]]);
    sum += weights.slope[static_cast<Eigen::Index>(k)] * residual * residual;
  }
  if (!with_bias) return sum;
  for (const auto& [a, b] : problem.neighbours)
    for (const Eigen::Index block : {n, 2 * n})
      sum += double{weights.bias_step} * std::pow(y[block + a] - y[block + b], 2);
  return sum + weights.bias_size * y.tail(2 * n).squaredNorm();
}

TEST(ViewSystem, IsTheQuadraticFormOfTheObjective) {
  const RangeView view = ragged_view();
  for (const Stencil stencil : {Stencil::kCompactEdge, Stencil::kPaperCentral}) {
    for (const bool with_bias : {true, false}) {
      const ViewProblem problem = make_view_problem(view, connect_samples(view), stencil);
      ViewSystem system(problem, with_bias);
      const ViewWeights weights = random_weights(problem, 3);
      system.assemble(weights);
      const Eigen::MatrixXd matrix =
          Eigen::MatrixXd(system.lower()).selfadjointView<Eigen::Lower>();
      const Eigen::Index size = matrix.rows();
      ASSERT_EQ(size, (with_bias ? 3 : 1) * static_cast<Eigen::Index>(problem.size()));
      const double constant = objective(problem, weights, Eigen::VectorXd::Zero(size), with_bias);
      for (std::uint32_t seed = 10; seed < 14; ++seed) {
        const Eigen::VectorXd y = random_vector(size, seed);
        const double expected = objective(problem, weights, y, with_bias);
        EXPECT_NEAR(y.dot(matrix * y) - 2.0 * system.rhs().dot(y) + constant, expected,
                    1e-9 * expected);
      }
      EXPECT_GT(matrix.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0.0);
    }
  }
}

TEST(ViewSystem, AssemblingAgainForgetsTheWeightsBefore) {
  const RangeView view = ragged_view();
  const ViewProblem problem = make_view_problem(view, connect_samples(view), Stencil::kCompactEdge);
  const ViewWeights first = random_weights(problem, 1), second = random_weights(problem, 3);
  ViewSystem once(problem, true), twice(problem, true);
  once.assemble(second);
  twice.assemble(first);
  twice.assemble(second);
  EXPECT_EQ((Eigen::MatrixXd(once.lower()) - Eigen::MatrixXd(twice.lower())).norm(), 0.0);
  EXPECT_EQ((once.rhs() - twice.rhs()).norm(), 0.0);
}

TEST(ViewProblem, NoConstraintCrossesWhatIsNotConnected) {
  const RangeView view = ragged_view();
  const ViewProblem problem = make_view_problem(view, connect_samples(view), Stencil::kCompactEdge);
  for (const SlopeConstraint& c : problem.slopes) {
    const std::uint32_t a = problem.pixels[c.tail], b = problem.pixels[c.head];
    EXPECT_EQ(a % 7 == 6, b % 7 == 6);
    for (const std::uint32_t i : {a, b}) EXPECT_TRUE(view.has_normal(int(i) % 7, int(i) / 7));
  }
  EXPECT_EQ(problem.size() + problem.pinned, view.sample_count());
}

}  // namespace
}  // namespace relief
