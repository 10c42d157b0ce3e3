// Where the smooth error of the normals changes fast, and what refining makes of it.

#include "hybrid/solver/bias_roughness.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "relief/hybrid/refine_view.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

ViewProblem problem_of(const RangeView& view) {
  return make_view_problem(view, connect_samples(view), Stencil::kCompactEdge);
}

RangeView ragged_view(int width, int height) {
  RangeView view = testing::render(testing::bumpy_surface(), testing::bumpy_camera(width, height));
  for (int v = 10; v < 20; ++v)
    for (int u = 5; u < 12; ++u) view.range(u, v) = kNoSample;
  return view;
}

TEST(BiasRoughness, IsTheMeanSquaredChangeInAWindowOverTheMedian) {
  const RangeView view = ragged_view(48, 40);
  const ViewProblem problem = problem_of(view);
  const auto n = static_cast<Eigen::Index>(problem.size());
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  Eigen::VectorXd y(3 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double size = problem.grid.u(problem.pixels[static_cast<std::size_t>(k)]) < 24 ? 1 : 5;
    y[n + k] = size * normal(generator);
    y[2 * n + k] = size * normal(generator);
  }
  // Each pair counts once at either end.
  std::vector<double> mean;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const int u = problem.grid.u(problem.pixels[k]), v = problem.grid.v(problem.pixels[k]);
    double sum = 0.0, count = 0.0;
    for (const auto& [a, b] : bias_neighbours(problem))
      for (const std::uint32_t end : {a, b}) {
        const std::uint32_t at = problem.pixels[end];
        if (std::abs(problem.grid.u(at) - u) > 8 || std::abs(problem.grid.v(at) - v) > 8) continue;
        sum += std::pow(y[n + a] - y[n + b], 2) + std::pow(y[2 * n + a] - y[2 * n + b], 2);
        count += 1.0;
      }
    mean.push_back(sum / count);
  }
  std::vector<double> sorted = mean;
  std::nth_element(sorted.begin(), sorted.begin() + n / 2, sorted.end());
  const double median = sorted[problem.size() / 2];
  const std::vector<float> rough = bias_roughness(problem, y);
  ASSERT_EQ(rough.size(), problem.size());
  for (std::size_t k = 0; k < problem.size(); ++k)
    EXPECT_NEAR(rough[k], std::max(1.0, mean[k] / median), 1e-4 * rough[k]);
}

TEST(BiasRoughness, NothingIsRoughWithoutABias) {
  const ViewProblem problem = problem_of(ragged_view(48, 40));
  const auto n = static_cast<Eigen::Index>(problem.size());
  EXPECT_TRUE(bias_roughness(problem, Eigen::VectorXd::Zero(n)).empty());
  EXPECT_TRUE(bias_roughness(problem, Eigen::VectorXd::Zero(3 * n)).empty());
}

// Turns normals about both tangents by waves of 24 samples, where `share` > 0 of up to `angle`.
template <typename Share>
void bend_normals(RangeView& view, double angle, const Share& share) {
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_normal(u, v)) continue;
      const double size = angle * share(u, v), phase = 2.0 * std::numbers::pi / 24.0;
      const Eigen::Vector3f measured = view.normals(u, v);
      Eigen::Vector3d normal = measured.cast<double>();
      normal += size * Eigen::Vector3d(std::sin(phase * u), std::cos(phase * v), 0.0);
      view.normals(u, v) = normal.normalized().cast<float>();
    }
}

struct Errors {
  double inside = 0.0, outside = 0.0, reported = 0.0;  // RMS [unit]; the latter inside.
};

Errors errors_of(const RefinedView& refined, const RangeView& truth, double radius) {
  Errors errors;
  double inside = 0.0, outside = 0.0;
  const double middle = 0.5 * truth.width();
  for (int v = 0; v < truth.height(); ++v)
    for (int u = 0; u < truth.width(); ++u) {
      const double squared = std::pow(refined.view.range(u, v) - truth.range(u, v), 2);
      const double from_middle = std::hypot(u - middle, v - middle);
      if (from_middle < radius) {
        errors.inside += squared, inside += 1.0;
        errors.reported += std::pow(refined.view.deviation(u, v), 2);
      } else if (from_middle > radius + 10.0) {
        errors.outside += squared, outside += 1.0;
      }
    }
  return {std::sqrt(errors.inside / inside), std::sqrt(errors.outside / outside),
          std::sqrt(errors.reported / inside)};
}

// As photometric stereo errs in shadows and highlights: in a part of the view only.
TEST(BiasRoughness, NormalsThatErrInOnePartCountLessThere) {
  constexpr int kSize = 200;
  constexpr double kRadius = 35.0;
  const RangeView truth =
      testing::render(testing::bumpy_surface(), testing::bumpy_camera(kSize, kSize));
  RangeView view = truth;
  testing::add_range_noise(view, 0.3, 1);
  testing::add_normal_noise(view, 1.0 * testing::kDegree, 2);
  testing::add_normal_bias(view, 1.5 * testing::kDegree);
  const RangeView even = view;
  bend_normals(view, 8.0 * testing::kDegree, [&](int u, int v) {
    return std::hypot(u - 0.5 * kSize, v - 0.5 * kSize) < kRadius ? 1.0 : 0.0;
  });
  const Errors uneven = errors_of(value_of(refine_view(view)), truth, kRadius);
  const Errors before = errors_of(value_of(refine_view(even)), truth, kRadius);
  RecordProperty("inside", std::to_string(uneven.inside));
  RecordProperty("reported", std::to_string(uneven.reported));
  RecordProperty("reported_before", std::to_string(before.reported));
  RecordProperty("outside", std::to_string(uneven.outside));
  RecordProperty("outside_before", std::to_string(before.outside));
  // With one sigma_b for the view: 0.245 inside.
  EXPECT_LT(uneven.inside, 0.2);
  EXPECT_GT(uneven.reported, 1.5 * before.reported);
  EXPECT_LT(uneven.outside, 1.3 * before.outside);
}

}  // namespace
}  // namespace relief::hybrid
