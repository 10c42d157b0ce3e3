#include "reconstruction/range_correction.h"

#include <cmath>

#include <gtest/gtest.h>

namespace relief::reconstruction {
namespace {

constexpr int kSide = 16;
const auto kNone = static_cast<float>(kNoSample);

// A slope with a block of 3 x 3 samples that stands `height` off it.
RangeView slope_with_a_block(double height) {
  RangeView view;
  view.camera =
      Camera::orthographic(kSide, kSide, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(),
                           Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ());
  view.range = {kSide, kSide, 0.0};
  for (int v = 0; v < kSide; ++v)
    for (int u = 0; u < kSide; ++u)
      view.range(u, v) =
          100.0 + 0.3 * u + (std::abs(u - 8) <= 1 && std::abs(v - 8) <= 1 ? height : 0.0);
  return view;
}

Grid<float> correction_of_the_block(float correction) {
  Grid<float> map(kSide, kSide, kNone);
  for (int v = 7; v <= 9; ++v)
    for (int u = 7; u <= 9; ++u) map(u, v) = correction;
  return map;
}

TEST(RangeCorrection, BringsBackWhatStandsApart) {
  RangeView view = slope_with_a_block(5.0);
  EXPECT_EQ(correct_ranges(correction_of_the_block(-5.0f), view), 9u);
  const RangeView slope = slope_with_a_block(0.0);
  for (std::size_t i = 0; i < view.range.size(); ++i)
    EXPECT_DOUBLE_EQ(view.range[i], slope.range[i]);
}

// The others look into a groove that this view does not see, for instance.
TEST(RangeCorrection, LeavesASmoothSurfaceWhole) {
  RangeView view = slope_with_a_block(0.0);
  EXPECT_EQ(correct_ranges(correction_of_the_block(5.0f), view), 0u);
  EXPECT_EQ(view.range(8, 8), slope_with_a_block(0.0).range(8, 8));
}

TEST(RangeCorrection, JudgesEachGroupByItself) {
  RangeView view = slope_with_a_block(5.0);
  Grid<float> correction = correction_of_the_block(-5.0f);
  for (int u = 2; u < 12; ++u) correction(u, 2) = -5.0f;
  EXPECT_EQ(correct_ranges(correction, view), 9u);
  EXPECT_EQ(view.range(2, 2), slope_with_a_block(5.0).range(2, 2));
}

TEST(RangeCorrection, LeavesFewSamplesToOthers) {
  for (const int samples : {4, 5}) {
    RangeView view = slope_with_a_block(0.0);
    Grid<float> correction(kSide, kSide, kNone);
    for (int u = 4; u < 4 + samples; ++u) {
      view.range(u, 8) += 5.0;
      correction(u, 8) = -5.0f;
    }
    EXPECT_EQ(correct_ranges(correction, view), samples == 5 ? 5u : 0u);
  }
}

// Steps to what is no sample do not count, and such pixels stay empty.
TEST(RangeCorrection, LeavesGapsEmpty) {
  RangeView view = slope_with_a_block(5.0);
  view.range(9, 9) = view.range(10, 8) = kNoSample;
  Grid<float> correction = correction_of_the_block(-5.0f);
  correction(9, 9) = kNone;
  EXPECT_EQ(correct_ranges(correction, view), 8u);
  EXPECT_FALSE(view.has_sample(9, 9));
  EXPECT_FALSE(view.has_sample(10, 8));
}

}  // namespace
}  // namespace relief::reconstruction
