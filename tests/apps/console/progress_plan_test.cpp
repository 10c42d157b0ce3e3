#include "apps/console/progress_plan.h"

#include <gtest/gtest.h>

namespace relief {
namespace {

TEST(ProgressPlan, SharesAreOfTheWhole) {
  ProgressPlan plan({{"align", 1.0}, {"refine", 2.0}, {"merge", 1.0}});
  EXPECT_DOUBLE_EQ(plan.overall("align", "", 0.5), 0.125);
  EXPECT_DOUBLE_EQ(plan.overall("refine", "", 0.0), 0.25);
  EXPECT_DOUBLE_EQ(plan.overall("refine", "", 0.5), 0.5);
  EXPECT_DOUBLE_EQ(plan.overall("merge", "", 1.0), 1.0);
}

TEST(ProgressPlan, NeverGoesBack) {
  ProgressPlan plan({{"align", 1.0}, {"merge", 1.0}});
  EXPECT_DOUBLE_EQ(plan.overall("align", "", 0.8), 0.4);
  EXPECT_DOUBLE_EQ(plan.overall("align", "", 0.1), 0.4);  // A step of its own starts at 0.
  EXPECT_DOUBLE_EQ(plan.overall("merge", "", 0.5), 0.75);
  EXPECT_DOUBLE_EQ(plan.overall("align", "", 1.0), 0.75);
}

TEST(ProgressPlan, StagesThatAreLeftOutAreDone) {
  ProgressPlan plan({{"align", 1.0}, {"refine", 2.0}, {"merge", 1.0}});
  plan.overall("align", "", 1.0);
  EXPECT_DOUBLE_EQ(plan.overall("merge", "", 0.0), 0.75);
  EXPECT_DOUBLE_EQ(plan.overall("of another plan", "", 0.5), 0.75);
}

TEST(ProgressPlan, StepsHaveSharesOfTheirOwn) {
  ProgressPlan plan({{"align", 1.0, "search"}, {"align", 3.0, "solve"}});
  EXPECT_DOUBLE_EQ(plan.overall("align", "search", 0.8), 0.2);
  EXPECT_DOUBLE_EQ(plan.overall("align", "another", 0.9), 0.2);
  EXPECT_DOUBLE_EQ(plan.overall("align", "solve", 0.0), 0.25);
}

TEST(ProgressPlan, WithoutStagesEachIsTheWhole) {
  ProgressPlan plan;
  EXPECT_DOUBLE_EQ(plan.overall("read", "", 1.0), 1.0);
  EXPECT_DOUBLE_EQ(plan.overall("align", "", 0.2), 0.2);
  EXPECT_DOUBLE_EQ(plan.overall("align", "", 0.1), 0.2);
}

TEST(ProgressPlan, TellsTheTimeLeftAtTheRateSoFar) {
  ProgressPlan plan({{"align", 1.0}, {"merge", 3.0}});
  EXPECT_LT(plan.seconds_left(10.0), 0.0);  // Nothing is done.
  plan.overall("align", "", 1.0);
  EXPECT_DOUBLE_EQ(plan.seconds_left(10.0), 30.0);
  EXPECT_LT(plan.seconds_left(0.5), 0.0);
  plan.overall("merge", "", 1.0);
  EXPECT_DOUBLE_EQ(plan.seconds_left(40.0), 0.0);
}

// The share of all stages before this one.
double share_before(const std::vector<PlannedStage>& stages, const std::string& name) {
  double sum = 0.0;
  for (const PlannedStage& stage : stages) {
    if (stage.name == name) break;
    sum += stage.share;
  }
  return sum;
}

TEST(ProgressPlan, SharesOfARunSumToOne) {
  for (const bool with_normals : {false, true})
    for (const double samples : {0.0, 3e4, 1e8})
      EXPECT_NEAR(share_before(stages_of_run({.views = 12,
                                              .refined_pixels = 2e8,
                                              .samples = samples,
                                              .with_normals = with_normals}),
                               ""),
                  1.0, 1e-12);
}

TEST(ProgressPlan, MaskedViewsSpendTheirTimeBeforeMerging) {
  // As measured: the bear's masks leave an eighth of the pixels, within a fifth of the grid.
  const auto masked = stages_of_run(
      {.views = 20, .refined_pixels = 1.43e6, .samples = 0.75e6, .with_normals = true});
  const auto full =
      stages_of_run({.views = 16, .refined_pixels = 9.7e6, .samples = 6.1e6, .with_normals = true});
  EXPECT_NEAR(share_before(masked, "merge"), 0.67, 0.04);
  EXPECT_NEAR(share_before(full, "merge"), 0.42, 0.03);
}

}  // namespace
}  // namespace relief
