#include "fusion/tsdf/closed_field.h"

#include <gtest/gtest.h>

#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

// A sphere seen from one side: half of its surface is for the field to find.
std::vector<ViewSampler> half_a_sphere() {
  auto views = testing::views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), 14, 60, 50.0);
  views.resize(3);
  std::vector<ViewSampler> samplers;
  for (const RangeView& view : views)
    samplers.push_back(std::move(ViewSampler::create(view, {})).value());
  return samplers;
}

TEST(ClosedField, IsSolvedToItsToleranceOrSaysThatItIsNot) {
  const auto views = half_a_sphere();
  ClosedFieldOptions options;
  options.voxel_size = 0.5;
  options.truncation = 1.5;
  const auto solved = value_of(compute_closed_field(views, options, {}));
  EXPECT_EQ(solved.moving_blocks, 0u);
  options.max_sweeps = 10;
  const auto cut_short = value_of(compute_closed_field(views, options, {}));
  EXPECT_GT(cut_short.moving_blocks, 0u);
}

}  // namespace
}  // namespace relief::fusion
