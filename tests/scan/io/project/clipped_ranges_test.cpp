#include "scan/io/project/loading/clipped_ranges.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

using ::testing::HasSubstr;

// In steps of 0.01.
RangeView sphere_view() {
  RangeView view = testing::render(testing::sphere({0, 0, 100}, 20),
                                   Camera::pinhole(150, 150, {300, 300, 74.5, 74.5}));
  view.name = "ball";
  for (double& range : view.range) range = std::round(range * 100.0) / 100.0;
  return view;
}

std::optional<std::string> note_on(const std::vector<RangeView>& views) {
  std::vector<ClippedRanges> clipped;
  for (const RangeView& view : views)
    if (auto found = find_clipped_ranges(view)) clipped.push_back(std::move(*found));
  return note_on_clipped_ranges(clipped, views.size());
}

TEST(ClippedRanges, ASurfaceAsItIsHasNone) {
  EXPECT_FALSE(note_on({sphere_view()}));
  RangeView coarse = sphere_view();
  for (double& range : coarse.range) range = std::round(range);
  EXPECT_FALSE(note_on({coarse}));
}

TEST(ClippedRanges, AWallWithNoiseHasNone) {
  RangeView wall = testing::render(testing::plane({0, 0, 100}, {0, 0, -1}),
                                   Camera::pinhole(150, 150, {300, 300, 74.5, 74.5}));
  testing::add_range_noise(wall, 0.02, 1);
  for (double& range : wall.range) range = std::round(range * 100.0) / 100.0;
  EXPECT_FALSE(note_on({wall}));
}

TEST(ClippedRanges, BothLimitsAreTold) {
  RangeView near = sphere_view(), far = near;
  far.name = "disc";
  for (double& range : near.range)
    if (range < 84.0) range = 84.0;
  for (double& range : far.range)
    if (range > 90.0) range = 90.0;
  const auto of_near = note_on({sphere_view(), near, far});
  ASSERT_TRUE(of_near);
  EXPECT_THAT(*of_near, HasSubstr("in 2 of 3 views"));
  EXPECT_THAT(*of_near, HasSubstr("the smallest depth"));
  EXPECT_THAT(*of_near, HasSubstr("in view ball at 84"));
  const auto of_far = note_on({far});
  ASSERT_TRUE(of_far);
  EXPECT_THAT(*of_far, HasSubstr("the largest depth"));
}

}  // namespace
}  // namespace relief
