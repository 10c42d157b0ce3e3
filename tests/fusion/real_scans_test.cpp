#include <gtest/gtest.h>

#include "relief/fusion/merge_views.h"
#include "relief/io/project_io.h"
#include "tests/support/result_matchers.h"
#include "tests/support/test_data.h"

namespace relief::fusion {
namespace {

TEST(RealScans, TheBunnyIsOneClosedManifold) {
  RELIEF_REQUIRE_TEST_DATA(path, "bunny/bun.conf");
  const auto project = value_of(read_project(path));
  MergeOptions options;
  options.voxel_size = 1.5e-3;  // [m] twice the sample spacing, for speed
  const auto merged = value_of(merge_views(project.views, options));
  const MergeResult& result = merged;
  EXPECT_TRUE(result.check.watertight());
  EXPECT_EQ(result.check.components, 1u);
  EXPECT_EQ(result.check.genus, 0);
  EXPECT_NEAR(result.check.volume, 7.55e-4, 0.05e-4);  // [m^3], of this merge at half the voxel
  EXPECT_LT(result.filled_area_fraction, 0.06);
}

}  // namespace
}  // namespace relief::fusion
