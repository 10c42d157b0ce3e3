#include "hybrid/noise/range_deviation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "hybrid/model/view_system.h"
#include "hybrid/noise/surface_average.h"
#include "relief/hybrid/refine_view.h"
#include "relief/scan/context.h"
#include "relief/scan/discontinuities.h"
#include "scan/base/counter_random.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

using testing::kDegree;
const MeasurementNoise kNoise{0.3, 1.5 * kDegree};

// A small view with a hole, an occlusion, a patch without normals and unequal confidences.
RangeView ragged_view() {
  RangeView view = testing::render(testing::bumpy_surface(), testing::bumpy_camera(9, 7));
  testing::add_range_noise(view, 0.2, 1);
  testing::add_normal_noise(view, 0.1, 2);
  view.range(2, 3) = kNoSample;
  for (int v = 0; v < 7; ++v) view.range(7, v) += 40.0;
  view.normals(4, 4).setConstant(static_cast<float>(kNoSample));
  view.confidence = Grid<float>(9, 7, 1.0f);
  view.confidence(0, 0) = 0.0f;
  view.confidence(5, 2) = 0.25f;
  return view;
}

ViewWeights weights_of(const ViewProblem& problem) {
  ViewWeights weights;
  weights.position.assign(problem.grid.size(), 0.0f);
  for (std::size_t k = 0; k < problem.size(); ++k)
    weights.position[problem.pixels[k]] = problem.confidence[static_cast<Eigen::Index>(k)] / 0.16f;
  for (auto& plane : weights.slope) plane.assign(problem.grid.size(), 0.0f);
  problem.slopes.for_each([&](int axis, std::size_t i) {
    weights.slope[static_cast<std::size_t>(axis)][i] = 1000.0f * static_cast<float>(1 + i % 3);
  });
  weights.bias_step.assign(problem.grid.size(), 0.0f);
  for (std::size_t k = 0; k < problem.size(); ++k)
    weights.bias_step[problem.pixels[k]] = 100.0f * static_cast<float>(1 + k % 3);
  weights.bias_size = 10.0f;
  return weights;
}

// Equation (H10) written down with dense matrices: one column for each independent error.
Eigen::VectorXd dense_deviation(const ViewProblem& problem, const ViewWeights& weights,
                                const Eigen::VectorXd& y) {
  const auto n = static_cast<Eigen::Index>(problem.size());
  const bool with_bias = y.size() > n;
  const std::vector<std::uint32_t> number = numbers_of(problem);
  ViewSystem system(problem, with_bias);
  system.assemble(weights);
  const Eigen::MatrixXd matrix = Eigen::MatrixXd(system.lower()).selfadjointView<Eigen::Lower>();
  Eigen::MatrixXd effect = Eigen::MatrixXd::Zero(matrix.rows(), 0);
  const auto new_column = [&] {
    effect.conservativeResize(Eigen::NoChange, effect.cols() + 1);
    effect.rightCols(1).setZero();
    return effect.col(effect.cols() - 1);
  };
  for (Eigen::Index i = 0; i < n; ++i)
    if (problem.confidence[i] > 0.0)
      new_column()(i) = weights.position[problem.pixels[static_cast<std::size_t>(i)]] *
                        kNoise.sigma_position / std::sqrt(problem.confidence[i]);
  for (const std::uint32_t pixel : problem.pixels) {
    for (const int normal_axis : {0, 1}) {
      auto column = new_column();
      problem.slopes.for_each([&](int axis, std::size_t i) {
        const auto ends = problem.slopes.ends(axis, i);
        const double share = 0.5 * ((ends.at0 == pixel) + (ends.at1 == pixel));
        if (axis != normal_axis || share == 0.0) return;
        const auto& plane = problem.slopes.axes[static_cast<std::size_t>(axis)];
        const double length = 2.0 * plane.half_length[i];
        const double error =
            weights.slope[static_cast<std::size_t>(axis)][i] * length * kNoise.sigma_normal * share;
        column(number[ends.tail]) += error * plane.tail_slope[i];
        column(number[ends.head]) -= error * plane.head_slope[i];
        if (!with_bias) return;
        for (const std::size_t at : {ends.at0, ends.at1})
          column((1 + axis) * n + number[at]) += 0.5 * length * error;
      });
    }
  }
  problem.slopes.for_each([&](int axis, std::size_t i) {
    auto column = new_column();
    const auto ends = problem.slopes.ends(axis, i);
    const auto& plane = problem.slopes.axes[static_cast<std::size_t>(axis)];
    const double error =
        weights.slope[static_cast<std::size_t>(axis)][i] *
        std::sqrt(problem.slopes.truncation_variance(axis, i, kNoise.sigma_normal));
    column(number[ends.tail]) += error * plane.tail_slope[i];
    column(number[ends.head]) -= error * plane.head_slope[i];
    if (!with_bias) return;
    for (const std::size_t at : {ends.at0, ends.at1})
      column((1 + axis) * n + number[at]) += plane.half_length[i] * error;
  });
  if (with_bias) {  // the prior's own matrix times the bias
    auto column = new_column();
    for (const Eigen::Index block : {n, 2 * n}) {
      column.segment(block, n) = weights.bias_size * y.segment(block, n);
      for (const auto& [a, b] : bias_neighbours(problem)) {
        const double step = weights.bias_step_between(problem.pixels[a], problem.pixels[b]);
        column(block + a) += step * (y[block + a] - y[block + b]);
        column(block + b) += step * (y[block + b] - y[block + a]);
      }
    }
  }
  return matrix.llt().solve(effect).topRows(n).rowwise().norm();
}

TEST(RangeDeviation, IsThatOfTheEstimatorWorkedOutWithDenseMatrices) {
  const RangeView view = ragged_view();
  for (const Stencil stencil : {Stencil::kCompactEdge, Stencil::kPaperCentral}) {
    for (const bool with_bias : {true, false}) {
      const ViewProblem problem = make_view_problem(view, connect_samples(view), stencil);
      const ViewWeights weights = weights_of(problem);
      const auto solver = make_view_solver(problem, with_bias, Solver::kCholesky);
      ASSERT_TRUE(solver->set_weights(weights));
      DeviationOptions options;
      options.probes = 20000;  // good to 0.5 percent each
      options.crossover = 0.0;
      Eigen::VectorXd y(static_cast<Eigen::Index>((with_bias ? 3 : 1) * problem.size()));
      for (Eigen::Index i = 0; i < y.size(); ++i) y[i] = 0.03 * std::sin(0.37 * double(i));
      const Eigen::VectorXf found = range_deviation(problem, weights, kNoise, y, *solver, options);
      const Eigen::VectorXd expected = dense_deviation(problem, weights, y);
      ASSERT_EQ(found.size(), expected.size());
      for (Eigen::Index i = 0; i < found.size(); ++i)
        EXPECT_NEAR(found[i] / expected[i], 1.0, 0.02) << i;
    }
  }
}

// Mean of (error / deviation)^2 over many samples and measurements: 1 when deviations are right.
struct Calibration {
  double inner = 0.0, border = 0.0;
};

struct Measurement {
  double sigma_position, sigma_normal_deg, bias_deg;
};

Calibration calibration(const RangeView& truth, const Measurement& m, const RefineOptions& options,
                        std::uint32_t seeds) {
  constexpr int kBorder = 3, kInner = 16;
  Calibration sum;
  double inner = 0.0, border = 0.0;
  for (std::uint32_t seed = 0; seed < seeds; ++seed) {
    RangeView view = truth;
    testing::add_range_noise(view, m.sigma_position, 100 + seed);
    testing::add_normal_noise(view, m.sigma_normal_deg * kDegree, 200 + seed);
    if (m.bias_deg > 0.0) testing::add_normal_bias(view, m.bias_deg * kDegree);
    const auto refined = value_of(refine_view(view, options));
    for (int v = 0; v < view.height(); ++v) {
      for (int u = 0; u < view.width(); ++u) {
        const int edge = std::min({u, v, view.width() - 1 - u, view.height() - 1 - v});
        const double error =
            (refined.view.range(u, v) - truth.range(u, v)) * view.camera.ray(u, v).direction.norm();
        const double squared = std::pow(error / refined.view.deviation(u, v), 2);
        if (edge >= kInner) sum.inner += squared, ++inner;
        if (edge < kBorder) sum.border += squared, ++border;
      }
    }
  }
  return {sum.inner / inner, sum.border / border};
}

RangeView plane_view(int size) {
  const double start = -0.5 * (size - 1);
  return testing::render(
      testing::plane({0, 0, 100}, {0.3, -0.2, 1}),
      Camera::orthographic(size, size, {start, start, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}));
}

TEST(RangeDeviation, ErrorsAreAsLargeAsDeviationsSay) {
  const RangeView plane = plane_view(96);
  const RangeView bumpy = testing::render(testing::bumpy_surface(), testing::bumpy_camera(96, 96));
  for (const RangeView* truth : {&plane, &bumpy}) {
    for (const Measurement& m : {Measurement{0.1, 1.5, 0.0},
                                 {0.1, 1.5, 4.0},
                                 {0.3, 1.5, 4.0},
                                 {0.3, 4.0, 0.0},
                                 {0.05, 3.0, 2.0}}) {
      const Calibration found = calibration(*truth, m, {}, 3);
      const auto at = ::testing::Message()
                      << m.sigma_position << " " << m.sigma_normal_deg << " " << m.bias_deg;
      EXPECT_GT(found.inner, 0.8) << at;
      EXPECT_LT(found.inner, 1.25) << at;
      EXPECT_GT(found.border, 0.8) << at;
      EXPECT_LT(found.border, 1.25) << at;
    }
  }
}

// Waves along u with exact normals, `wavelength` samples long, whose slopes reach a half.
RangeView wave_view(double wavelength) {
  RangeView view = plane_view(64);
  view.normals = Grid<Eigen::Vector3f>(64, 64);
  const double k = 2.0 * std::numbers::pi / wavelength;
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 64; ++u) {
      view.range(u, v) = 100.0 + 0.5 / k * std::sin(k * u);
      view.normals(u, v) =
          Eigen::Vector3d(0.5 * std::cos(k * u), 0.0, -1.0).normalized().cast<float>();
    }
  }
  return view;
}

TEST(RangeDeviation, KnowsWhatTheStencilErrsByOnReliefNearTheSampling) {
  for (const double wavelength : {4.7, 8.3, 14.9}) {
    const RangeView view = wave_view(wavelength);
    const ViewProblem problem =
        make_view_problem(view, connect_samples(view), Stencil::kCompactEdge);
    double errors = 0.0, expected = 0.0;
    problem.slopes.for_each([&](int axis, std::size_t i) {
      errors += std::pow(problem.slopes.axes[static_cast<std::size_t>(axis)].step[i], 2);
      expected += problem.slopes.truncation_variance(axis, i, 0.0);
    });
    EXPECT_LT(errors, expected) << wavelength;
    EXPECT_GT(errors, 0.02 * expected) << wavelength;
  }
}

// A roof of the slopes +-`slope`, its ridge anywhere between two samples in each row.
RangeView roof_view(double slope) {
  RangeView view = plane_view(64);
  for (int v = 0; v < 64; ++v) {
    const double ridge = 31.0 + (v + 0.5) / 64.0;
    for (int u = 0; u < 64; ++u) {
      view.range(u, v) = 100.0 + slope * std::abs(u - ridge);
      view.normals(u, v) =
          Eigen::Vector3d(u < ridge ? -slope : slope, 0.0, -1.0).normalized().cast<float>();
    }
  }
  return view;
}

TEST(RangeDeviation, KnowsWhatTheStencilErrsByAtCreases) {
  for (const double slope : {0.02, 0.05, 0.1}) {
    const RangeView view = roof_view(slope);
    const ViewProblem problem =
        make_view_problem(view, connect_samples(view), Stencil::kCompactEdge);
    double errors = 0.0, expected = 0.0;
    for (int v = 0; v < 64; ++v) {
      const std::size_t i = problem.grid.index(31, v);
      errors += std::pow(problem.slopes.axes[0].step[i], 2);
      expected += problem.slopes.truncation_variance(0, i, 0.0);
    }
    EXPECT_NEAR(std::sqrt(expected / errors), 1.0, 0.3) << slope;
  }
}

TEST(RangeDeviation, TakesNoNoiseForRelief) {
  const double sigma = 0.02;
  RangeView view = plane_view(64);
  testing::add_normal_noise(view, sigma, 5);
  const ViewProblem problem = make_view_problem(view, connect_samples(view), Stencil::kCompactEdge);
  double taken = 0.0, noise = 0.0;
  problem.slopes.for_each([&](int axis, std::size_t i) {
    const double half = problem.slopes.axes[static_cast<std::size_t>(axis)].half_length[i];
    taken += problem.slopes.truncation_variance(axis, i, sigma);
    noise += std::pow(2.0 * half * sigma, 2);
  });
  EXPECT_LT(taken, 0.1 * noise);
}

TEST(RangeDeviation, HoldsForEveryModelOfTheBiasAndWeight) {
  const RangeView truth = plane_view(64);
  RefineOptions options;
  options.bias = BiasModel::kNone;
  for (const auto lambda : {std::optional<double>(), std::optional<double>(0.3)}) {
    options.lambda = lambda;
    const Calibration found = calibration(truth, {0.1, 1.5, 0.0}, options, 6);
    EXPECT_NEAR(found.inner, 1.0, 0.25);
    EXPECT_NEAR(found.border, 1.0, 0.25);
  }
}

RangeView noisy_view(int size = 64) {
  RangeView view = testing::render(testing::bumpy_surface(), testing::bumpy_camera(size, size));
  testing::add_range_noise(view, 0.3, 1);
  testing::add_normal_noise(view, 1.5 * kDegree, 2);
  testing::add_normal_bias(view, 2.0 * kDegree);
  return view;
}

Grid<float> deviation_of(const RangeView& view, const RefineOptions& options = {}) {
  const auto refined = value_of(refine_view(view, options));
  EXPECT_EQ(refined.view.deviation.size(), view.range.size());
  return refined.view.deviation;
}

TEST(RangeDeviation, TheNumberOfThreadsChangesNoByte) {
  const RangeView view = noisy_view(100);
  const auto deviation_on = [&](int threads) {
    return on_threads(threads, [&] { return deviation_of(view); });
  };
  const Grid<float> one = deviation_on(1);
  for (const int threads : {2, 4}) {
    const Grid<float> many = deviation_on(threads);
    EXPECT_EQ(std::memcmp(one.data(), many.data(), one.size() * sizeof(float)), 0);
  }
}

TEST(RangeDeviation, HasTheUnitOfTheRange) {
  const RangeView view = noisy_view();
  RangeView large = view;
  for (double& t : large.range) t *= 1000.0;
  const Grid<float> a = deviation_of(view), b = deviation_of(large);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(b[i] / a[i], 1000.0, 1.0);
}

TEST(RangeDeviation, GrowsAtBordersAndWhereNothingIsTrusted) {
  RangeView view = plane_view(96);
  testing::add_range_noise(view, 0.1, 1);
  testing::add_normal_noise(view, 1.5 * kDegree, 2);
  view.confidence = Grid<float>(96, 96, 1.0f);
  for (int v = 30; v < 66; ++v)
    for (int u = 30; u < 66; ++u) view.confidence(u, v) = 0.0f;
  for (int v = 80; v < 90; ++v)
    for (int u = 5; u < 15; ++u) {
      view.normals(u, v).setConstant(static_cast<float>(kNoSample));
      view.confidence(u, v) = u < 12 ? 0.25f : 0.0f;
    }
  RefineOptions options;
  options.sigma_position = 0.1;
  options.sigma_normal = 1.5 * kDegree;
  const Grid<float> deviation = deviation_of(view, options);
  EXPECT_GT(deviation(0, 48), 1.2 * deviation(15, 48));
  EXPECT_GT(deviation(0, 0), 1.2 * deviation(0, 48));
  EXPECT_GT(deviation(48, 48), 1.25 * deviation(15, 48));
  EXPECT_FLOAT_EQ(deviation(10, 85), 0.2f) << "as measured: sigma / sqrt(confidence)";
  EXPECT_EQ(deviation(13, 85), std::numeric_limits<float>::infinity());
}

// Ranges are so noisy that positions and normals cross at 76 samples, and a tenth of the samples
// are missing in squares of one to three.
TEST(RangeDeviation, GapsThatAreSmallAgainstTheCrossoverChangeLittle) {
  constexpr int size = 96;
  const RangeView truth = plane_view(size);
  RangeView whole = truth;
  testing::add_range_noise(whole, 2.0, 1);
  testing::add_normal_noise(whole, 1.5 * kDegree, 2);
  RangeView gaps = whole;
  const CounterRandom random(5, 0);
  for (int v = 1; v + 3 < size; v += 4)
    for (int u = 1; u + 3 < size; u += 4) {
      const auto bits = random.bits(static_cast<std::size_t>(v * size + u));
      if (bits % 5 > 1) continue;
      const int side = 1 + static_cast<int>(bits / 5 % 3);
      for (int k = 0; k < side * side; ++k) gaps.range(u + k % side, v + k / side) = kNoSample;
    }
  RefineOptions options;
  options.sigma_position = 2.0;
  options.sigma_normal = 1.5 * kDegree;
  const Grid<float> of_whole = deviation_of(whole, options), of_gaps = deviation_of(gaps, options);
  double squares = 0.0, count = 0.0;
  for (int v = 0; v < size; ++v)
    for (int u = 0; u < size; ++u) {
      if (!gaps.has_sample(u, v)) continue;
      const double ratio = of_gaps(u, v) / of_whole(u, v);
      EXPECT_LT(ratio, 2.0) << u << ' ' << v;
      squares += ratio * ratio, ++count;
    }
  EXPECT_GT(std::sqrt(squares / count), 0.8);
  EXPECT_LT(std::sqrt(squares / count), 1.3);
}

// Half a plane, and from it strands one sample wide, as at the rim of dark patches.
TEST(RangeDeviation, IsNoMoreThanTheRangeAloneLeaves) {
  constexpr double sigma = 0.3;
  RangeView view = plane_view(96);
  testing::add_range_noise(view, sigma, 1);
  testing::add_normal_noise(view, 1.5 * kDegree, 2);
  for (int v = 0; v < 96; ++v)
    for (int u = 48; u < 96; ++u)
      if (v % 8 != 0) view.range(u, v) = kNoSample;
  RefineOptions options;
  options.sigma_position = sigma;
  const auto refined = value_of(refine_view(view, options));
  const auto largest = std::ranges::max_element(refined.view.deviation);
  EXPECT_LE(*largest, sigma * (1.0 + 1e-6));
  EXPECT_LT(refined.view.deviation(20, 50), 0.3 * sigma);
}

TEST(RangeDeviation, IsLeftOutWhenNotAskedFor) {
  RefineOptions options;
  options.deviation = false;
  RangeView view = noisy_view(32);
  view.deviation = Grid<float>(32, 32, 1.0f);  // of the measurement, not of the refined range
  const auto refined = value_of(refine_view(view, options));
  EXPECT_TRUE(refined.view.deviation.empty());
}

TEST(SurfaceAverage, WeighsByTheDistanceAlongRowsAndColumnsAndCrossesNoCut) {
  RangeView view = plane_view(12);
  for (int v = 0; v < 12; ++v) view.range(7, v) = kNoSample;
  const ViewProblem problem = make_view_problem(view, connect_samples(view), Stencil::kCompactEdge);
  const SurfaceAverage surface(problem, 2.0);
  const auto count = static_cast<Eigen::Index>(problem.size());
  Eigen::VectorXf values(count), expected(count), shares(count);
  for (Eigen::Index k = 0; k < count; ++k)
    values[k] = static_cast<float>(std::cos(0.7 * double(k * k)));
  const double line = (1.0 + std::exp(-0.5)) / (1.0 - std::exp(-0.5));
  const auto u_of = [&](Eigen::Index k) {
    return problem.grid.u(problem.pixels[static_cast<std::size_t>(k)]);
  };
  const auto v_of = [&](Eigen::Index k) {
    return problem.grid.v(problem.pixels[static_cast<std::size_t>(k)]);
  };
  for (Eigen::Index i = 0; i < count; ++i) {
    double sum = 0.0, weights = 0.0;
    for (Eigen::Index k = 0; k < count; ++k) {
      if ((u_of(i) < 7) != (u_of(k) < 7)) continue;
      const double distance = std::abs(u_of(i) - u_of(k)) + std::abs(v_of(i) - v_of(k));
      sum += std::exp(-distance / 2.0) * values[k];
      weights += std::exp(-distance / 2.0);
    }
    expected[i] = static_cast<float>(sum / weights);
    shares[i] = static_cast<float>(weights / (line * line));
  }
  EXPECT_LT((surface.average(values, 2.0) - expected).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((surface.share(2.0) - shares).cwiseAbs().maxCoeff(), 1e-6);
}

// A plane with a cut from one border to the middle, and single samples missing.
TEST(SurfaceAverage, GoesRoundWhatIsSmallAgainstTheWindow) {
  constexpr int size = 128;
  const auto problem_of = [](const RangeView& view) {
    return make_view_problem(view, connect_samples(view), Stencil::kCompactEdge);
  };
  const RangeView whole = plane_view(size);
  RangeView gaps = whole;
  for (int v = 3; v < size; v += 7)
    for (int u = 2 + v % 5; u < size; u += 6) gaps.range(u, v) = kNoSample;
  const ViewProblem problem = problem_of(whole), with_gaps = problem_of(gaps);
  const Eigen::VectorXf all = SurfaceAverage(problem, 40.0).share(40.0);
  const SurfaceAverage surface(with_gaps, 40.0);
  const Eigen::VectorXf share = surface.share(40.0);
  const std::vector<std::uint32_t> number = numbers_of(problem);
  for (Eigen::Index k = 0; k < share.size(); ++k) {
    const std::uint32_t pixel = with_gaps.pixels[static_cast<std::size_t>(k)];
    EXPECT_NEAR(share[k] / all[number[pixel]], 1.0, 0.15)
        << with_gaps.grid.u(pixel) << ' ' << with_gaps.grid.v(pixel);
  }
  const Eigen::VectorXf ones = Eigen::VectorXf::Constant(share.size(), 3.0f);
  EXPECT_LT((surface.average(ones, 40.0) - ones).cwiseAbs().maxCoeff(), 1e-5);
}

// Two halves that a cut parts all along stay apart in cells of any size.
TEST(SurfaceAverage, LargeWindowsCrossNoCut) {
  constexpr int size = 129;  // The cut is inside of the cells.
  RangeView view = plane_view(size);
  for (int v = 0; v < size; ++v)
    for (int u = 61 + v % 3; u < size; ++u) view.range(u, v) += 40.0;
  const ViewProblem problem = make_view_problem(view, connect_samples(view), Stencil::kCompactEdge);
  Eigen::VectorXf values(static_cast<Eigen::Index>(problem.size()));
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const std::uint32_t pixel = problem.pixels[static_cast<std::size_t>(k)];
    values[k] = problem.grid.u(pixel) < 61 + problem.grid.v(pixel) % 3 ? 1.0f : 2.0f;
  }
  const Eigen::VectorXf average = SurfaceAverage(problem, 60.0).average(values, 60.0);
  EXPECT_LT((average - values).cwiseAbs().maxCoeff(), 1e-5);
}

}  // namespace
}  // namespace relief::hybrid
