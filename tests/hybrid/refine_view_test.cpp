#include "relief/hybrid/refine_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/support/degree.h"
#include "tests/support/geometry_matchers.h"
#include "tests/support/parameter_names.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

using testing::bumpy_camera;
using testing::bumpy_surface;
using testing::errors_of;
using testing::kDegree;

const Camera kOrthographic =
    Camera::orthographic(64, 48, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});

RangeView noisy_view(double range_noise, double normal_noise_deg, double bias_deg, int size = 256) {
  RangeView view = testing::render(bumpy_surface(), bumpy_camera(size, size));
  testing::add_range_noise(view, range_noise, 1);
  testing::add_normal_noise(view, normal_noise_deg * kDegree, 2);
  testing::add_normal_bias(view, bias_deg * kDegree);
  return view;
}

RefinedView refined(const RangeView& view, const RefineOptions& options = {}) {
  return value_of(refine_view(view, options));
}

double largest_change(const RangeView& a, const RangeView& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.range.size(); ++i)
    if (a.range[i] == a.range[i]) largest = std::max(largest, std::abs(a.range[i] - b.range[i]));
  return largest;
}

RefineOptions with_known_noise(double sigma_position, double sigma_normal) {
  RefineOptions options;
  options.sigma_position = sigma_position;
  options.sigma_normal = sigma_normal;
  return options;
}

class RefineViewOfCamera : public ::testing::TestWithParam<Camera> {};
INSTANTIATE_TEST_SUITE_P(Cameras, RefineViewOfCamera,
                         ::testing::Values(kOrthographic, Camera::pinhole(64, 48, {80, 70, 30, 20}),
                                           Camera::pinhole_gl(64, 48, {80, 70, 30, 20})),
                         testing::PrintedName());

TEST_P(RefineViewOfCamera, APlaneWithItsNormalsStaysAsItIs) {
  const double side = GetParam().ray(30, 20).direction.z();
  const RangeView view =
      testing::render(testing::plane({0, 0, 100 * side}, {0.3, -0.2, 1}), GetParam());
  const RefinedView result = refined(view, with_known_noise(0.1, 0.01));
  EXPECT_EQ(result.status, RefineStatus::kRefined);
  EXPECT_EQ(result.refined, view.sample_count());
  EXPECT_EQ(result.view.samples, SampleOrigin::kRefined);
  EXPECT_LT(largest_change(view, result.view), 2e-5);  // normals are floats
}

TEST(RefineView, ASphereWithItsNormalsStaysAsItIs) {
  // Equation (H4) is exact on circles: every grid line of an orthographic view of a sphere is one.
  const RangeView view = testing::render(testing::sphere({31, 23, 100}, 20), kOrthographic);
  RefineOptions options = with_known_noise(1.0, 0.001);
  options.bias = BiasModel::kNone;
  EXPECT_LT(largest_change(view, refined(view, options).view), 2e-5);
  options.stencil = Stencil::kPaperCentral;
  EXPECT_GT(largest_change(view, refined(view, options).view), 1e-2);
}

TEST(RefineView, TheCompactStencilSeesACheckerboardThatTheCentralOneDoesNot) {
  const RangeView truth = testing::render(testing::plane({0, 0, 100}, {0, 0, 1}), kOrthographic);
  RangeView view = truth;
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u) view.range(u, v) += (u + v) % 2 ? 0.1 : -0.1;
  RefineOptions options = with_known_noise(0.1, 0.03);
  options.robust_rounds = 0;
  EXPECT_LT(errors_of(refined(view, options).view, truth).depth_rms, 0.1 / 20.0);
  options.stencil = Stencil::kPaperCentral;
  // One-sided differences at the border see it: look further inside.
  EXPECT_GT(std::abs(refined(view, options).view.range(32, 24) - 100.0), 0.09);
}

TEST(RefineView, RefinedViewsAreCloserToTheTruthByTheFactorsPromised) {
  const RangeView truth = testing::render(bumpy_surface(), bumpy_camera());
  const RangeView view = noisy_view(0.3, 1.5, 4.0);
  const auto raw = errors_of(view, truth);
  const RefinedView result = refined(view);
  const auto after = errors_of(result.view, truth);
  EXPECT_LT(after.depth_rms, raw.depth_rms / 5.0);
  EXPECT_LT(after.surface_normals, raw.surface_normals / 10.0);
  EXPECT_LT(after.normals, raw.normals / 2.0);
  EXPECT_NEAR(result.sigma_position, 0.3, 0.03);
  EXPECT_NEAR(result.sigma_normal, 1.5 * kDegree, 0.15 * kDegree);
}

TEST(RefineView, WithoutNormalsTheViewIsAsMeasured) {
  RangeView view = noisy_view(0.3, 1.0, 0.0, 48);
  view.normals = {};
  const RefinedView result = refined(view);
  EXPECT_EQ(result.status, RefineStatus::kNoNormals);
  EXPECT_NEAR(result.sigma_position, 0.3, 0.03);
  EXPECT_EQ(largest_change(view, result.view), 0.0);
  EXPECT_EQ(result.kept, view.sample_count());
}

TEST(RefineView, ColoursStayWithTheirSamples) {
  RangeView view = noisy_view(0.3, 1.0, 0.0, 48);
  view.colours = Grid<Colour>(view.width(), view.height(), Colour{1, 2, 3});
  view.colours(20, 30) = {4, 5, 6};
  const RefinedView result = refined(view);
  EXPECT_EQ(result.view.colours.size(), view.colours.size());
  EXPECT_EQ(result.view.colours(20, 30), (Colour{4, 5, 6}));
}

TEST(RefineView, SamplesWithoutNormalsKeepTheirRange) {
  RangeView view = noisy_view(0.3, 1.0, 0.0, 64);
  for (int v = 20; v < 40; ++v)
    for (int u = 10; u < 50; ++u) view.normals(u, v).setConstant(static_cast<float>(kNoSample));
  const RefinedView result = refined(view);
  EXPECT_EQ(result.kept, 800u);
  EXPECT_EQ(result.view.range(30, 30), view.range(30, 30));
  EXPECT_NE(result.view.range(30, 10), view.range(30, 10));
}

TEST(RefineView, DegenerateViewsHaveDefinedOutcomes) {
  RangeView empty;
  empty.camera = kOrthographic;
  empty.range = Grid<double>(64, 48, kNoSample);
  EXPECT_EQ(refined(empty).status, RefineStatus::kNoNormals);

  RangeView single = testing::render(testing::plane({0, 0, 9}, {0, 0, 1}), kOrthographic);
  for (std::size_t i = 1; i < single.range.size(); ++i) single.range[i] = kNoSample;
  EXPECT_EQ(refined(single).status, RefineStatus::kNoNormals);

  RangeView constant = testing::render(testing::plane({0, 0, 9}, {0, 0, 1}), kOrthographic);
  const RefinedView same = refined(constant);
  EXPECT_EQ(largest_change(constant, same.view), 0.0);

  constant.confidence = Grid<float>(64, 48, 0.0f);
  EXPECT_EQ(refined(constant, with_known_noise(0.1, 0.01)).status, RefineStatus::kNoConfidence);
}

TEST(RefineView, BadOptionsAreNamed) {
  const RangeView view = noisy_view(0.3, 1.0, 0.0, 16);
  RefineOptions options;
  options.lambda = 1.0;
  EXPECT_THAT(refine_view(view, options), HasError(ErrorKind::kBadInput, "lambda"));
}

TEST(RefineView, StopsOnRequest) {
  const auto result = refine_view(noisy_view(0.3, 1.0, 0.0, 32), {},
                                  {.progress = [](double, std::string_view) { return false; }});
  EXPECT_THAT(result, HasError(ErrorKind::kInterrupted));
}

TEST(RefineView, TheNumberOfThreadsChangesNoByte) {
  const RangeView view = noisy_view(0.3, 1.5, 4.0, 96);
  const auto refined_on = [&](int threads) {
    return on_threads(threads, [&] { return refined(view); });
  };
  const RefinedView one = refined_on(1), four = refined_on(4);
  EXPECT_EQ(std::memcmp(one.view.range.data(), four.view.range.data(),
                        one.view.range.size() * sizeof(double)),
            0);
  EXPECT_EQ(std::memcmp(one.view.normals.data(), four.view.normals.data(),
                        one.view.normals.size() * sizeof(Eigen::Vector3f)),
            0);
}

TEST(RefineView, MultigridAgreesWithCholesky) {
  const RangeView view = noisy_view(0.3, 1.5, 4.0, 96);
  for (const BiasModel bias : {BiasModel::kLatent, BiasModel::kNone}) {
    RefineOptions options;
    options.bias = bias;
    options.tolerance = 1e-10;
    options.robust_rounds = 0;  // rounds in between are solved roughly on purpose
    const RefinedView iterative = refined(view, options);
    options.solver = Solver::kCholesky;
    const RefinedView direct = refined(view, options);
    EXPECT_LT(largest_change(iterative.view, direct.view), 1e-6);
  }
}

TEST(RefineView, NothingDependsOnTheUnit) {
  const RangeView view = noisy_view(0.3, 1.5, 4.0, 64);
  RangeView large = view;
  for (double& t : large.range) t *= 1000.0;
  const RefinedView a = refined(view), b = refined(large);
  EXPECT_NEAR(b.sigma_position, 1000.0 * a.sigma_position, 0.1 * a.sigma_position);
  for (std::size_t i = 0; i < view.range.size(); ++i)
    EXPECT_NEAR(b.view.range[i], 1000.0 * a.view.range[i], 1e-3);
}

TEST(RefineView, NothingDependsOnTheFrameOrTheDirectionOfTheGrid) {
  const RangeView view = noisy_view(0.3, 1.5, 4.0, 64);
  RefineOptions options = with_known_noise(0.3, 1.5 * kDegree);
  options.sigma_bias_step = 0.01;  // its estimate steps over samples in the order of the grid
  options.tolerance = 1e-10;
  options.robust_rounds = 0;
  const RefinedView reference = refined(view, options);
  // The same rays as a table, in another frame and with the columns in reverse order.
  const RigidMotion other_from_view = testing::look_at({3, 4, 5}, {1, -2, 0});
  Grid<Ray> rays(64, 64);
  RangeView moved = view;
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 64; ++u) {
      const Ray ray = view.camera.ray(63 - u, v);
      rays(u, v) = {other_from_view * ray.origin, other_from_view.linear() * ray.direction};
      moved.range(u, v) = view.range(63 - u, v);
      moved.normals(u, v) = other_from_view.linear().cast<float>() * view.normals(63 - u, v);
    }
  }
  moved.camera = Camera::ray_table(std::move(rays), std::nullopt);
  const RefinedView result = refined(moved, options);
  for (int v = 0; v < 64; ++v)
    for (int u = 0; u < 64; ++u)
      EXPECT_NEAR(result.view.range(u, v), reference.view.range(63 - u, v), 1e-3) << u << " " << v;
}

TEST(RefineView, ConvergesWithTheSecondOrderOfTheSpacing) {
  // True normals, and nearly no weight on positions: what is left is the error of the stencil.
  std::array<double, 2> errors{};
  for (const int level : {0, 1}) {
    const int size = 48 << level;
    const double spacing = 1.0 / (1 << level);
    const Camera camera = Camera::orthographic(size, size, {-24, -24, 0}, {spacing, 0, 0},
                                               {0, spacing, 0}, {0, 0, 1});
    const RangeView truth = testing::render(bumpy_surface(), camera);
    RefineOptions options = with_known_noise(1e4, 0.01);
    options.bias = BiasModel::kNone;
    options.robust_rounds = 0;
    errors[static_cast<std::size_t>(level)] =
        errors_of(refined(truth, options).view, truth).depth_rms;
  }
  EXPECT_GT(errors[0] / errors[1], 3.3);
  EXPECT_LT(errors[0] / errors[1], 5.0);
}

class RefineViewOfAStep : public ::testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Heights, RefineViewOfAStep, ::testing::Values(1.5, 5.0, 50.0),
                         testing::PrintedName());

TEST_P(RefineViewOfAStep, StaysSharp) {
  RangeView truth = testing::render(testing::plane({0, 0, 90}, {0.2, 0.1, 1}), kOrthographic);
  for (int v = 0; v < 48; ++v)
    for (int u = 32; u < 64; ++u) truth.range(u, v) += GetParam();
  RangeView view = truth;
  testing::add_range_noise(view, 0.15, 4);
  testing::add_normal_noise(view, 1.5 * kDegree, 5);
  const RefinedView result = refined(view);
  double step = 0.0;
  for (int v = 4; v < 44; ++v) step += (result.view.range(32, v) - result.view.range(31, v)) / 40.0;
  EXPECT_NEAR(step, truth.range(32, 20) - truth.range(31, 20), 0.1);
  EXPECT_LT(errors_of(result.view, truth).depth_rms, 0.06);
}

TEST(RefineView, AThirdOfWildNormalsIsNoDisaster) {
  const RangeView truth = testing::render(bumpy_surface(), bumpy_camera(96, 96));
  RangeView view = noisy_view(0.3, 1.5, 2.0, 96);
  testing::add_normal_outliers(view, 0.3, 3);
  const auto raw = errors_of(view, truth), after = errors_of(refined(view).view, truth);
  EXPECT_LT(after.depth_rms, raw.depth_rms / 2.5);
  EXPECT_LT(after.surface_normals, raw.surface_normals / 4.0);
  EXPECT_LT(after.normals, raw.normals / 2.5);
  RefineOptions options;
  options.robust_rounds = 0;
  EXPECT_GT(errors_of(refined(view, options).view, truth).surface_normals,
            1.5 * after.surface_normals);
}

TEST(RefineView, TheLatentBiasBeatsCorrectionBeforehandAndBothBeatNone) {
  const RangeView truth = testing::render(bumpy_surface(), bumpy_camera(128, 128));
  const RangeView view = noisy_view(1.0, 1.5, 4.0, 128);
  RefineOptions options;
  const auto latent = errors_of(refined(view, options).view, truth);
  options.bias = BiasModel::kTwoStep;
  const auto two_step = errors_of(refined(view, options).view, truth);
  options.bias = BiasModel::kNone;
  const auto none = errors_of(refined(view, options).view, truth);
  EXPECT_LT(latent.depth_rms, 0.5 * two_step.depth_rms);
  EXPECT_LT(latent.normals, two_step.normals);
  EXPECT_LT(two_step.depth_rms, none.depth_rms);
  EXPECT_LT(two_step.normals, none.normals);
}

TEST(RefineView, LambdaWeighsPositionsAgainstNormals) {
  const RangeView view = noisy_view(0.3, 1.5, 0.0, 64);
  RefineOptions options;
  options.bias = BiasModel::kNone;
  double before = 1e9;
  for (const double lambda : {0.01, 0.1, 0.9, 0.9999}) {
    options.lambda = lambda;
    const RefinedView result = refined(view, options);
    EXPECT_NEAR(result.lambda, lambda, 1e-9);
    EXPECT_LT(result.rms_change, before);
    before = result.rms_change;
  }
  EXPECT_LT(before, 1e-3);
}

TEST(RefineView, SamplesOfNoConfidenceFollowTheirNeighboursAndNormals) {
  const RangeView truth = testing::render(bumpy_surface(), bumpy_camera(64, 64));
  RangeView view = noisy_view(0.1, 0.5, 0.0, 64);
  view.confidence = Grid<float>(64, 64, 1.0f);
  for (int u = 10; u < 50; ++u) {
    view.confidence(u, 30) = 0.0f;
    view.range(u, 30) += 0.8;
  }
  EXPECT_LT(errors_of(refined(view).view, truth).depth_rms, 0.03);
}

TEST(RefineView, DeviationsOfAViewAreTheNoiseOfItsRanges) {
  RangeView by_confidence = noisy_view(0.3, 1.5, 2.0, 64), by_deviation = by_confidence;
  by_confidence.confidence = by_deviation.deviation = Grid<float>(64, 64);
  for (int v = 0; v < 64; ++v) {
    for (int u = 0; u < 64; ++u) {
      by_confidence.confidence(u, v) = u < 16 ? 0.25f : 1.0f;
      by_deviation.deviation(u, v) = u < 16 ? 0.6f : 0.3f;
    }
  }
  RefineOptions options = with_known_noise(0.3f, 1.5 * kDegree);
  const RefinedView expected = refined(by_confidence, options);
  options.sigma_position.reset();
  const RefinedView found = refined(by_deviation, options);
  EXPECT_FLOAT_EQ(found.sigma_position, 0.3f) << "the median deviation";
  EXPECT_LT(largest_change(found.view, expected.view), 1e-6);
  EXPECT_NEAR(found.view.deviation(5, 5), expected.view.deviation(5, 5), 1e-5);

  by_deviation.deviation(40, 40) = static_cast<float>(kNoSample);
  by_deviation.confidence = Grid<float>(64, 64, 1.0f);
  EXPECT_LT(largest_change(refined(by_deviation, options).view, expected.view), 1e-6)
      << "where none is known, the confidence counts";
}

TEST(RefineView, TheSeedIsThatOfTheDeviationsAlone) {
  const RangeView view = noisy_view(0.3, 1.5, 2.0, 64);
  const RefinedView first = refine_view(view).value();
  const RefinedView second = refine_view(view, {}, {.seed = 2}).value();
  EXPECT_EQ(largest_change(first.view, second.view), 0.0);
  EXPECT_NE(first.view.deviation(30, 30), second.view.deviation(30, 30));
  EXPECT_NEAR(first.view.deviation(30, 30) / second.view.deviation(30, 30), 1.0, 0.4);
}

}  // namespace
}  // namespace relief::hybrid
