// Alignment of views with the errors of real sensors, from disturbed poses and without any.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/result_matchers.h"

namespace relief::registration {
namespace {

const std::vector<RangeView>& truth() {
  static const auto ring = testing::ring_of_views();
  return ring;
}

double spacing() {
  static const double value = sample_spacing(truth()[0]);
  return value;
}

void lose_at_random(RangeView& view, int percent) {
  for (std::size_t i = 0; i < view.range.size(); ++i)
    if ((static_cast<std::uint32_t>(i) * 2654435761u >> 9) % 100 <
        static_cast<std::uint32_t>(percent))
      view.range[i] = kNoSample;
}

void round_ranges(RangeView& view, double step) {
  for (double& range : view.range) range = step * std::round(range / step);
}

template <typename Spoil>
std::vector<RangeView> spoiled(const Spoil& spoil) {
  auto views = testing::perturbed(truth(), Eigen::Vector3d::Zero(), 0.04, 2.0 * spacing());
  for (RangeView& view : views) spoil(view);
  return views;
}

// The worst view's mean displacement from its true place [sample spacings]; all views have to be
// aligned.
double worst_error(const std::vector<RangeView>& views) {
  const auto aligned = value_of(align_views(views));
  EXPECT_TRUE(aligned.complete());
  for (const auto& view : aligned.views)
    EXPECT_EQ(view.status, PoseStatus::kVerified) << view.name << ": " << view.reason;
  const auto errors =
      testing::mean_displacements(truth(), aligned.world_from_view(), testing::poses_of(truth()));
  return *std::max_element(errors.begin(), errors.end()) / spacing();
}

TEST(SensorErrors, SamplesMissingAtRandomHardlyMatter) {
  EXPECT_LT(worst_error(spoiled([](RangeView& view) { lose_at_random(view, 15); })), 0.13);
}

TEST(SensorErrors, RangesRoundedToStepsOfTwoAndFourSpacings) {
  for (const double steps : {2.0, 4.0}) {
    const double error =
        worst_error(spoiled([&](RangeView& view) { round_ranges(view, steps * spacing()); }));
    // What rounding leaves, were its errors independent from terrace to terrace.
    EXPECT_LT(error, 0.25 * steps);
  }
}

TEST(SensorErrors, NoiseFiveTimesAsLargeInOneHalf) {
  std::uint32_t seed = 1;
  const double error = worst_error(spoiled([&](RangeView& view) {
    RangeView noisy = view;
    testing::add_range_noise(noisy, 1.5, ++seed);
    for (int v = 0; v < view.height(); ++v)
      for (int u = view.width() / 2; u < view.width(); ++u) view.range(u, v) = noisy.range(u, v);
  }));
  EXPECT_LT(error, 0.3);
}

TEST(SensorErrors, ASmoothErrorOfItsOwnInEveryView) {
  int k = 0;
  const double error = worst_error(spoiled([&](RangeView& view) {
    ++k;
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        view.range(u, v) += 0.5 * spacing() * std::sqrt(2.0) * std::sin(0.03 * u + 1.3 * k) *
                            std::cos(0.025 * v + 0.7 * k);
  }));
  EXPECT_LT(error, 0.7);
}

}  // namespace
}  // namespace relief::registration
