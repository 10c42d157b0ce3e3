#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "hybrid/multigrid/view_multigrid.h"
#include "hybrid/solver/view_solver.h"
#include "relief/hybrid/refine_view.h"
#include "relief/scan/context.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

// Conjugate gradient steps to 1e-6, whatever the data.
constexpr int kFewSteps = 25;

RangeView noisy_view(int size) {
  RangeView view = testing::render(testing::bumpy_surface(), testing::bumpy_camera(size, size));
  testing::add_range_noise(view, 0.3, 1);
  testing::add_normal_noise(view, 0.026, 2);
  return view;
}

// Without each sample for which `keep(u, v)` is false.
template <typename Keep>
RangeView masked(RangeView view, const Keep& keep) {
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (!keep(u, v)) view.range(u, v) = kNoSample;
  return view;
}

RangeView with_holes(RangeView view, double fraction) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  return masked(std::move(view), [&](int, int) { return uniform(generator) >= fraction; });
}

ViewProblem problem_of(const RangeView& view) {
  return make_view_problem(view, connect_samples(view), Stencil::kCompactEdge);
}

// Lengths in samples at which positions and normals cross, and bias and normals.
struct Scales {
  double position, bias;
};

// Weights of these scales; `jumps` orders of magnitude between the weights of constraints. In one
// place the bias changes `rough` times as fast [variance].
ViewWeights weights_of(const ViewProblem& problem, Scales scales, double jumps = 0.0,
                       double rough = 1.0) {
  const double sigma_position = 0.3, sigma_normal = sigma_position / scales.position;
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  ViewWeights weights;
  weights.position.assign(problem.grid.size(), 0.0f);
  for (std::size_t k = 0; k < problem.size(); ++k)
    weights.position[problem.pixels[k]] = static_cast<float>(1.0 / std::pow(sigma_position, 2));
  for (auto& plane : weights.slope) plane.assign(problem.grid.size(), 0.0f);
  problem.slopes.for_each([&](int axis, std::size_t i) {
    const auto a = static_cast<std::size_t>(axis);
    const double sigma = 2.0 * problem.slopes.axes[a].half_length[i] * sigma_normal;
    const double share = std::pow(10.0, -jumps * std::pow(uniform(generator), 4));
    weights.slope[a][i] = static_cast<float>(share / (sigma * sigma));
  });
  weights.bias_step.assign(problem.grid.size(), 0.0f);
  for (const std::uint32_t i : problem.pixels) {
    const double squared =
        std::pow(problem.grid.u(i) - 40, 2) + std::pow(problem.grid.v(i) - 40, 2);
    const double here = 1.0 + (rough - 1.0) * std::exp(-squared / (2.0 * 12.0 * 12.0));
    weights.bias_step[i] = static_cast<float>(scales.bias / (sigma_normal * std::sqrt(here)));
  }
  weights.bias_size = 8.0f;
  return weights;
}

struct Solved {
  Eigen::VectorXd y;
  LinearSolve how;
};

Solved solve(const ViewProblem& problem, const ViewWeights& weights, Solver kind,
             double tolerance = 1e-6, bool with_bias = true) {
  const auto solver = make_view_solver(problem, with_bias, kind);
  Solved solved;
  EXPECT_TRUE(solver->set_weights(weights));
  solved.y = Eigen::VectorXd::Zero((with_bias ? 3 : 1) * static_cast<Eigen::Index>(problem.size()));
  solved.how = solver->minimise(solved.y, tolerance, 500);
  return solved;
}

constexpr Scales kScales[] = {{0.01, 0.3}, {1, 1},    {10, 1}, {100, 1},
                              {100, 100},  {1e3, 10}, {1e4, 1}};

TEST(Multigrid, AgreesWithTheDirectSolverOnRaggedMasksJumpsAndAllRatios) {
  for (const double holes : {0.0, 0.2}) {
    const RangeView view = with_holes(noisy_view(48), holes);
    const ViewProblem problem = problem_of(view);
    for (const Scales scales : kScales) {
      for (const bool with_bias : {true, false}) {
        const ViewWeights weights = weights_of(problem, scales, 3.0, 50.0);
        const Solved direct = solve(problem, weights, Solver::kCholesky, 0.0, with_bias);
        const Solved iterative = solve(problem, weights, Solver::kMultigrid, 1e-11, with_bias);
        EXPECT_TRUE(iterative.how.converged);
        const auto n = static_cast<Eigen::Index>(problem.size());
        const auto x = direct.y.head(n);
        EXPECT_LT((iterative.y.head(n) - x).norm(), 1e-6 * x.norm())
            << holes << " " << scales.position << " " << scales.bias;
        if (!with_bias) continue;
        const auto b = direct.y.tail(2 * n);
        EXPECT_LT((iterative.y.tail(2 * n) - b).norm(), 1e-6 * b.norm());
      }
    }
  }
}

TEST(Multigrid, TheDefaultToleranceIsTheErrorOfTheRange) {
  const double tolerance = RefineOptions().tolerance;
  for (const double holes : {0.0, 0.2}) {
    const ViewProblem problem = problem_of(with_holes(noisy_view(72), holes));
    const auto n = static_cast<Eigen::Index>(problem.size());
    for (const Scales scales : kScales) {
      for (const double jumps : {0.0, 2.0}) {
        const ViewWeights weights = weights_of(problem, scales, jumps);
        const Eigen::VectorXd x = solve(problem, weights, Solver::kCholesky).y.head(n);
        const Eigen::VectorXd found =
            solve(problem, weights, Solver::kMultigrid, tolerance).y.head(n);
        EXPECT_LT((found - x).norm(), tolerance * x.norm())
            << holes << " " << scales.position << " " << scales.bias << " " << jumps;
      }
    }
  }
}

TEST(Multigrid, NeedsFewStepsWhateverTheSizeAndTheRatio) {
  for (const int size : {32, 128, 384}) {
    const ViewProblem problem = problem_of(noisy_view(size));
    for (const Scales scales : kScales)
      EXPECT_LE(solve(problem, weights_of(problem, scales), Solver::kMultigrid).how.iterations,
                kFewSteps)
          << size << " " << scales.position << " " << scales.bias;
  }
}

TEST(Multigrid, NeedsHardlyMoreStepsWhereTheBiasIsRoughInOnePlace) {
  const ViewProblem problem = problem_of(noisy_view(128));
  for (const Scales scales : kScales)
    EXPECT_LE(
        solve(problem, weights_of(problem, scales, 0.0, 50.0), Solver::kMultigrid).how.iterations,
        kFewSteps + 5)
        << scales.position << " " << scales.bias;
}

TEST(Multigrid, NeedsFewStepsWhateverTheMask) {
  const RangeView full = noisy_view(120);
  const auto steps = [](const RangeView& view, Scales scales, double jumps) {
    const ViewProblem problem = problem_of(view);
    return solve(problem, weights_of(problem, scales, jumps), Solver::kMultigrid).how.iterations;
  };
  for (const Scales scales : {Scales{10, 1}, Scales{1e3, 10}, Scales{1e5, 1}}) {
    EXPECT_LE(steps(with_holes(full, 0.1), scales, 0.0), kFewSteps);
    // Over a thousand islands.
    EXPECT_LE(steps(masked(full, [](int u, int v) { return u % 3 != 2 && v % 3 != 2; }), scales, 0),
              kFewSteps);
    // Lines one sample wide.
    EXPECT_LE(steps(masked(full, [](int u, int) { return u % 2 == 0; }), scales, 0.0), kFewSteps);
    EXPECT_LE(steps(masked(full, [](int, int v) { return v % 2 == 0; }), scales, 0.0), kFewSteps);
    // One line folded up: long, and nothing but turns.
    EXPECT_LE(
        steps(masked(full, [](int u, int v) { return v % 2 == 0 || u == (v % 4 == 1 ? 119 : 0); }),
              scales, 0.0),
        2 * kFewSteps);
    EXPECT_LE(steps(full, scales, 4.0), 2 * kFewSteps);  // neighbours' weights differ by 10^4
  }
}

TEST(Multigrid, OneSetupServesManyRightSides) {
  const ViewProblem problem = problem_of(noisy_view(40));
  const auto solver = make_view_solver(problem, true, Solver::kMultigrid);
  const auto reference = make_view_solver(problem, true, Solver::kCholesky);
  const ViewWeights weights = weights_of(problem, {10, 1});
  ASSERT_TRUE(solver->set_weights(weights));
  ASSERT_TRUE(reference->set_weights(weights));
  for (int probe = 0; probe < 3; ++probe) {
    Eigen::VectorXd rhs(3 * static_cast<Eigen::Index>(problem.size()));
    for (Eigen::Index i = 0; i < rhs.size(); ++i) rhs[i] = std::sin(1.0 + probe + 0.7 * double(i));
    Eigen::VectorXd y = rhs, expected = rhs;
    EXPECT_TRUE(solver->solve(y, 1e-10, 100).converged);
    reference->solve(expected, 0.0, 1);
    EXPECT_LT((y - expected).norm(), 1e-7 * expected.norm());
  }
  Eigen::VectorXd y = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(problem.size()));
  EXPECT_GT(solver->minimise(y, 1e-10, 100).iterations, 0);
  EXPECT_EQ(solver->minimise(y, 1e-8, 100).iterations, 0) << "it starts from the solution";
}

TEST(Multigrid, TheNumberOfThreadsChangesNoByte) {
  const ViewProblem problem = problem_of(with_holes(noisy_view(150), 0.05));
  const ViewWeights weights = weights_of(problem, {30, 2}, 2.0);
  const auto solve_on = [&](int threads) {
    return on_threads(threads, [&] { return solve(problem, weights, Solver::kMultigrid); });
  };
  const Solved one = solve_on(1);
  for (const int threads : {2, 4}) {
    const Solved more = solve_on(threads);
    EXPECT_EQ(one.how.iterations, more.how.iterations);
    EXPECT_EQ((one.y - more.y).cwiseAbs().maxCoeff(), 0.0);
  }
}

}  // namespace
}  // namespace relief::hybrid
