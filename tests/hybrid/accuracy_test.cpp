// How good refined views are with default options, against what is possible, against the published
// method, and against the measurements themselves.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "relief/hybrid/refine_view.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

using testing::bumpy_camera;
using testing::bumpy_surface;
using testing::errors_of;
using testing::kDegree;
using testing::ViewErrors;

constexpr double kPi = std::numbers::pi;

RangeView refined(const RangeView& view, const RefineOptions& options = {}) {
  auto result = value_of(refine_view(view, options));
  EXPECT_EQ(result.status, RefineStatus::kRefined);
  return std::move(result.view);
}

// Samples at unit spacing on parallel rays.
Camera unit_grid(int size) {
  return Camera::orthographic(size, size, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
}

// Gentle waves of more than 90 samples, on which the stencil's own error is far below any noise.
testing::Surface smooth_surface() {
  return [](const Ray& ray) -> std::optional<testing::SurfaceHit> {
    const double a = 0.05 * ray.origin.x() + 0.02 * ray.origin.y();
    const double b = 0.045 * ray.origin.y() - 0.03 * ray.origin.x();
    const double height = 2.0 * std::sin(a) + 1.5 * std::cos(b);
    const Eigen::Vector3d normal(0.1 * std::cos(a) + 0.045 * std::sin(b),
                                 0.04 * std::cos(a) - 0.0675 * std::sin(b), -1.0);
    return testing::SurfaceHit{100.0 + height, normal.normalized()};
  };
}

// Equation (H15): the least RMS error that any linear estimator reaches at unit spacing with the
// model of stencil (H4), white noise and nothing known of the surface.
double least_rms(double sigma_position, double sigma_normal) {
  constexpr int kFrequencies = 256;
  const auto information = [&](int k) {
    const double frequency = 2.0 * kPi * (k + 0.5) / kFrequencies - kPi;
    return std::pow(2.0 * std::tan(0.5 * frequency) / sigma_normal, 2);
  };
  double variance = 0.0;
  for (int v = 0; v < kFrequencies; ++v)
    for (int u = 0; u < kFrequencies; ++u)
      variance += 1.0 / (1.0 / (sigma_position * sigma_position) + information(u) + information(v));
  return std::sqrt(variance) / kFrequencies;
}

double inner_rms(const RangeView& view, const RangeView& truth, int margin) {
  double sum = 0.0;
  for (int v = margin; v < view.height() - margin; ++v)
    for (int u = margin; u < view.width() - margin; ++u)
      sum += std::pow(view.range(u, v) - truth.range(u, v), 2);
  return std::sqrt(sum) / (view.width() - 2 * margin);
}

TEST(Accuracy, IsCloseToTheLeastErrorPossible) {
  const RangeView truth = testing::render(smooth_surface(), unit_grid(192));
  for (const auto& [range_noise, normal_noise_deg] : {std::pair{0.05, 0.3},
                                                      {0.05, 1.5},
                                                      {0.05, 5.0},
                                                      {0.1, 5.0},
                                                      {0.3, 1.5},
                                                      {0.3, 5.0},
                                                      {1.0, 1.5},
                                                      {1.0, 5.0}}) {
    const double sigma_normal = normal_noise_deg * kDegree;
    RangeView view = truth;
    testing::add_range_noise(view, range_noise, 1);
    testing::add_normal_noise(view, sigma_normal, 2);
    // Beyond a few crossover lengths from the border, a sample has all the help it can get.
    const int margin = std::min(48, static_cast<int>(std::ceil(2.0 * range_noise / sigma_normal)));
    EXPECT_LT(inner_rms(refined(view), truth, margin), 1.15 * least_rms(range_noise, sigma_normal))
        << range_noise << " " << normal_noise_deg;
  }
}

TEST(Accuracy, BeatsThePublishedMethodAtItsBest) {
  const RangeView truth = testing::render(bumpy_surface(), bumpy_camera(224, 224));
  RangeView view = truth;
  testing::add_range_noise(view, 0.3, 1);
  testing::add_normal_noise(view, 1.5 * kDegree, 2);
  testing::add_normal_bias(view, 4.0 / std::sqrt(2.0) * kDegree);  // along each tangent
  ViewErrors best{1e9, 1e9, 1e9};
  RefineOptions published;
  published.stencil = Stencil::kPaperCentral;
  published.bias = BiasModel::kTwoStep;
  published.robust_rounds = 0;
  // The best of a wider sweep, with its neighbours.
  for (const auto& [lambda, scale] :
       {std::pair{0.01, 4.5}, {0.01, 6.0}, {0.01, 8.0}, {0.003, 6.0}, {0.03, 6.0}}) {
    published.lambda = lambda;
    published.smoothing_scale = scale;
    const ViewErrors errors = errors_of(refined(view, published), truth);
    best.depth_rms = std::min(best.depth_rms, errors.depth_rms);
    best.surface_normals = std::min(best.surface_normals, errors.surface_normals);
    best.normals = std::min(best.normals, errors.normals);
  }
  const ViewErrors ours = errors_of(refined(view), truth);
  EXPECT_LT(ours.depth_rms, 0.6 * best.depth_rms);
  EXPECT_LT(ours.surface_normals, 0.6 * best.surface_normals);
  EXPECT_LT(ours.normals, best.normals);
}

TEST(Accuracy, IsNeverWorseThanTheBetterOfTheTwoMeasurements) {
  const RangeView truth = testing::render(bumpy_surface(), bumpy_camera(112, 112));
  // What finite differences of the exact samples err by is nobody's noise.
  const double discretisation = errors_of(truth, truth).surface_normals;
  for (const double range_noise : {0.05, 0.3, 1.0}) {
    for (const double normal_noise_deg : {0.3, 1.5, 5.0}) {
      for (const double bias_deg : {0.0, 4.0, 10.0}) {
        RangeView view = truth;
        testing::add_range_noise(view, range_noise, 1);
        testing::add_normal_noise(view, normal_noise_deg * kDegree, 2);
        testing::add_normal_bias(view, bias_deg * kDegree);
        const ViewErrors raw = errors_of(view, truth), after = errors_of(refined(view), truth);
        const auto trace = ::testing::Message()
                           << range_noise << " " << normal_noise_deg << " " << bias_deg;
        EXPECT_LT(after.depth_rms, raw.depth_rms) << trace;
        EXPECT_LT(after.surface_normals,
                  std::hypot(std::min(raw.surface_normals, raw.normals), discretisation))
            << trace;
        EXPECT_LT(after.normals, 1.001 * raw.normals) << trace;
      }
    }
  }
}

TEST(Accuracy, ACheckerboardFallsTwentyfold) {
  const RangeView truth =
      testing::render(testing::plane({0, 0, 100}, {0.2, 0.1, 1}), unit_grid(64));
  for (const double height : {0.01, 0.1, 1.0}) {
    RangeView view = truth;
    for (int v = 0; v < 64; ++v)
      for (int u = 0; u < 64; ++u) view.range(u, v) += (u + v) % 2 ? height : -height;
    EXPECT_LT(errors_of(refined(view), truth).depth_rms, height / 20.0) << height;
  }
}

// Noise that neighbouring samples share is estimated well enough that knowing its level over long
// waves would help little.
TEST(Accuracy, SuffersLittleFromNoiseThatNeighboursShare) {
  const RangeView truth = testing::render(bumpy_surface(), bumpy_camera(128, 128));
  struct Case {
    double range_noise;
    int range_size;
    double normal_noise_deg;
    int normal_size;
    double bias_deg;
  };
  for (const Case& c :
       {Case{0.3, 1, 1.5, 3, 0.0}, Case{0.3, 1, 1.5, 5, 4.0}, Case{0.3, 1, 5.0, 5, 4.0},
        Case{1.0, 3, 1.5, 1, 0.0}, Case{1.0, 5, 5.0, 1, 4.0}, Case{0.3, 3, 1.5, 3, 4.0}}) {
    RangeView view = truth;
    testing::add_smoothed_range_noise(view, c.range_noise, c.range_size, 1);
    testing::add_smoothed_normal_noise(view, c.normal_noise_deg * kDegree, c.normal_size, 2);
    testing::add_normal_bias(view, c.bias_deg * kDegree);
    RefineOptions known;
    known.sigma_position = c.range_noise;
    known.sigma_normal = c.normal_noise_deg * kDegree;
    EXPECT_LT(errors_of(refined(view), truth).depth_rms,
              1.1 * errors_of(refined(view, known), truth).depth_rms)
        << c.range_size << " " << c.normal_size << " " << c.bias_deg;
  }
}

}  // namespace
}  // namespace relief::hybrid
