#include "apps/commands/plan/step_costs.h"

#include <gtest/gtest.h>

namespace relief {
namespace {

using reconstruction::Stage;

// The bear of the test data.
constexpr ProjectSize kSize{.views = 20,
                            .pairs = 190,
                            .pixels = 6.27e6,
                            .refined_pixels = 1.43e6,
                            .samples = 0.75e6,
                            .with_normals = true};

TEST(StepCosts, BlocksShareTheSamplesAndReadAllViewsEach) {
  const StepCost whole = cost_of(Stage::kRefine, kSize), half = cost_of(Stage::kRefine, kSize, 0.5),
                 none = cost_of(Stage::kRefine, kSize, 0.0);
  EXPECT_NEAR(2.0 * half.cpu_seconds, whole.cpu_seconds + none.cpu_seconds, 1e-9);
  EXPECT_NEAR(2.0 * half.disk_bytes, whole.disk_bytes, 1e-3);
  EXPECT_GT(half.memory_bytes, none.memory_bytes);
  // No block reads longer than it works.
  const auto blocks = static_cast<double>(blocks_to_refine(kSize));
  EXPECT_GE(whole.cpu_seconds - none.cpu_seconds, blocks * none.cpu_seconds);
}

TEST(StepCosts, WithoutNormalsNothingIsRefined) {
  ProjectSize size = kSize;
  size.with_normals = false;
  EXPECT_EQ(blocks_to_refine(size), 1);
  EXPECT_EQ(cost_of(Stage::kRefine, size).cpu_seconds,
            cost_of(Stage::kRefine, size, 0.0).cpu_seconds);
  EXPECT_LT(cost_of(Stage::kAlignAgain, size).cpu_seconds,
            0.5 * cost_of(Stage::kAlignAgain, kSize).cpu_seconds);
  EXPECT_EQ(cost_of(Stage::kMerge, size).cpu_seconds, cost_of(Stage::kMerge, kSize).cpu_seconds);
}

TEST(StepCosts, BricksShareTheIntegrationAlone) {
  const double one = cost_of_brick(kSize, 1).cpu_seconds, two = cost_of_brick(kSize, 2).cpu_seconds;
  const double four = cost_of_brick(kSize, 4).cpu_seconds;
  EXPECT_NEAR(one - two, 2.0 * (two - four), 1e-9);
  EXPECT_GT(four, 0.5 * one);
  const StepCost after = cost_of_merge_after_parts(kSize), merge = cost_of(Stage::kMerge, kSize);
  EXPECT_LT(after.cpu_seconds, merge.cpu_seconds);
  EXPECT_GT(after.cpu_seconds + cost_of_coarse_field(kSize).cpu_seconds + one, merge.cpu_seconds);
}

TEST(StepCosts, PairsAreSearchedInBlocksWhereThatIsMostOfTheWork) {
  // A thousand small views.
  ProjectSize size{.views = 1000,
                   .pairs = 12'000,
                   .first_pairs = 2000,
                   .pixels = 12e6,
                   .samples = 10e6,
                   .search = true};
  const std::size_t blocks = blocks_to_search(size);
  EXPECT_GT(blocks, 2);
  const double one = cost_of_search(size, 1).cpu_seconds;
  EXPECT_LT(cost_of_search(size, blocks).cpu_seconds, 0.5 * one);
  EXPECT_LT(one, cost_of(Stage::kAlign, size).cpu_seconds);
  // Describing large views takes longer.
  size.samples = 300e6;
  EXPECT_EQ(blocks_to_search(size), 0);
  size.samples = 10e6;
  size.search = false;
  EXPECT_EQ(blocks_to_search(size), 0);
}

}  // namespace
}  // namespace relief
