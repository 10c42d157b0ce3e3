#include "hybrid/refine_view.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/hybrid/bumpy_view.h"
#include "tests/support/synthetic_views.h"

namespace relief {
namespace {

using testing::bumpy_camera;
using testing::bumpy_surface;
using testing::errors_of;

constexpr double kDegree = std::numbers::pi / 180.0;
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
  auto result = refine_view(view, options);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
  return *result;
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

TEST(RefineView, APlaneWithItsNormalsStaysAsItIs) {
  for (const Camera& camera : {kOrthographic, Camera::pinhole(64, 48, {80, 70, 30, 20}),
                               Camera::pinhole_gl(64, 48, {80, 70, 30, 20})}) {
    const double side = camera.ray(30, 20).direction.z();
    const RangeView view =
        testing::render(testing::plane({0, 0, 100 * side}, {0.3, -0.2, 1}), camera);
    const RefinedView result = refined(view, with_known_noise(0.1, 0.01));
    EXPECT_EQ(result.status, RefineStatus::kRefined);
    EXPECT_EQ(result.refined, view.sample_count());
    EXPECT_LT(largest_change(view, result.view), 2e-5);  // normals are floats
  }
}

TEST(RefineView, ASphereWithItsNormalsStaysAsItIs) {
  // Equation (6) is exact on circles: every grid line of an orthographic view of a sphere is one.
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
  EXPECT_EQ(largest_change(view, result.view), 0.0);
  EXPECT_EQ(result.kept, view.sample_count());
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
  const auto result = refine_view(view, options);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().kind, ErrorKind::kBadInput);
  EXPECT_NE(result.error().message.find("lambda"), std::string::npos);
}

TEST(RefineView, StopsOnRequest) {
  const auto result = refine_view(noisy_view(0.3, 1.0, 0.0, 32), {},
                                  [](double, std::string_view) { return false; });
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().kind, ErrorKind::kInterrupted);
}

TEST(RefineView, TheNumberOfThreadsChangesNoByte) {
  const RangeView view = noisy_view(0.3, 1.5, 4.0, 96);
  RefineOptions options;
  options.threads = 1;
  const RefinedView one = refined(view, options);
  options.threads = 4;
  const RefinedView four = refined(view, options);
  EXPECT_EQ(std::memcmp(one.view.range.data(), four.view.range.data(),
                        one.view.range.size() * sizeof(double)),
            0);
  EXPECT_EQ(std::memcmp(one.view.normals.data(), four.view.normals.data(),
                        one.view.normals.size() * sizeof(Eigen::Vector3f)),
            0);
}

TEST(RefineView, ConjugateGradientsAgreeWithCholesky) {
  const RangeView view = noisy_view(0.3, 1.5, 4.0, 96);
  for (const BiasModel bias : {BiasModel::kLatent, BiasModel::kNone}) {
    RefineOptions options;
    options.bias = bias;
    options.tolerance = 1e-9;
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

}  // namespace
}  // namespace relief
