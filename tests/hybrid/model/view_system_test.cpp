#include "hybrid/model/view_system.h"

#include <random>
#include <string>
#include <tuple>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "scan/base/linear_algebra.h"
#include "tests/hybrid/bumpy_view.h"

namespace relief::hybrid {
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
  const auto plane = [&](std::uint32_t plane_seed) {
    const Eigen::VectorXd values =
        random_vector(static_cast<Eigen::Index>(problem.grid.size()), plane_seed);
    return std::vector<float>(values.begin(), values.end());
  };
  return {plane(seed), {plane(seed + 1), plane(seed + 2)}, plane(seed + 3), 0.2f};
}

// The objective (H5) written down from the definition of its residuals.
double objective(const ViewProblem& problem, const ViewWeights& weights, const Eigen::VectorXd& y,
                 bool with_bias) {
  const auto n = static_cast<Eigen::Index>(problem.size());
  const std::vector<std::uint32_t> number = numbers_of(problem);
  double sum = 0.0;
  for (Eigen::Index i = 0; i < n; ++i)
    sum += double{weights.position[problem.pixels[static_cast<std::size_t>(i)]]} * y[i] * y[i];
  problem.slopes.for_each([&](int axis, std::size_t i) {
    const auto& a = problem.slopes.axes[static_cast<std::size_t>(axis)];
    const auto ends = problem.slopes.ends(axis, i);
    double residual = double{a.step[i]} + double{a.head_slope[i]} * y[number[ends.head]] -
                      double{a.tail_slope[i]} * y[number[ends.tail]];
    const Eigen::Index bias = (1 + axis) * n;
    if (with_bias)
      residual -=
          double{a.half_length[i]} * (y[bias + number[ends.at0]] + y[bias + number[ends.at1]]);
    sum += double{weights.slope[static_cast<std::size_t>(axis)][i]} * residual * residual;
  });
  if (!with_bias) return sum;
  for (const auto& [a, b] : bias_neighbours(problem))
    for (const Eigen::Index block : {n, 2 * n})
      sum += weights.bias_step_between(problem.pixels[a], problem.pixels[b]) *
             std::pow(y[block + a] - y[block + b], 2);
  return sum + double{weights.bias_size} * y.tail(2 * n).squaredNorm();
}

class ViewSystemOfAModel : public ::testing::TestWithParam<std::tuple<Stencil, bool>> {};
INSTANTIATE_TEST_SUITE_P(StencilsAndBias, ViewSystemOfAModel,
                         ::testing::Combine(::testing::Values(Stencil::kCompactEdge,
                                                              Stencil::kPaperCentral),
                                            ::testing::Bool()),
                         [](const auto& test) {
                           const bool compact =
                               std::get<Stencil>(test.param) == Stencil::kCompactEdge;
                           return std::string(compact ? "CompactEdge" : "PaperCentral") +
                                  (std::get<bool>(test.param) ? "WithBias" : "");
                         });

TEST_P(ViewSystemOfAModel, IsTheQuadraticFormOfTheObjective) {
  const auto [stencil, with_bias] = GetParam();
  const RangeView view = ragged_view();
  const ViewProblem problem = make_view_problem(view, connect_samples(view), stencil);
  ViewSystem system(problem, with_bias);
  const ViewWeights weights = random_weights(problem, 3);
  system.assemble(weights);
  const Eigen::MatrixXd matrix = Eigen::MatrixXd(system.lower()).selfadjointView<Eigen::Lower>();
  const Eigen::Index size = matrix.rows();
  ASSERT_EQ(size, (with_bias ? 3 : 1) * static_cast<Eigen::Index>(problem.size()));
  const double constant = objective(problem, weights, Eigen::VectorXd::Zero(size), with_bias);
  for (std::uint32_t seed = 10; seed < 14; ++seed) {
    const Eigen::VectorXd y = random_vector(size, seed);
    const double expected = objective(problem, weights, y, with_bias);
    EXPECT_NEAR(y.dot(matrix * y) - 2.0 * system.rhs().dot(y) + constant, expected,
                1e-9 * expected);
  }
  EXPECT_GT(eigen_decomposition(matrix).eigenvalues()[0], 0.0);
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
  std::size_t constraints = 0;
  problem.slopes.for_each([&](int axis, std::size_t i) {
    const auto ends = problem.slopes.ends(axis, i);
    const PaddedGrid& grid = problem.grid;
    EXPECT_EQ(grid.u(ends.tail) == 6, grid.u(ends.head) == 6);
    for (const std::size_t end : {ends.tail, ends.head})
      EXPECT_TRUE(view.has_normal(grid.u(end), grid.v(end)));
    ++constraints;
  });
  EXPECT_EQ(constraints, problem.constraints);
  EXPECT_EQ(problem.size() + problem.pinned, view.sample_count());
}

}  // namespace
}  // namespace relief::hybrid
