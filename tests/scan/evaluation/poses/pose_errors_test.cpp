#include "relief/evaluation/pose_errors.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::evaluation {
namespace {

using testing::kDegree;

ScanProject views_of_a_sphere(int count) {
  const Camera camera = Camera::pinhole(40, 40, {80, 80, 19.5, 19.5});
  ScanProject project;
  for (int i = 0; i < count; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / count;
    const RigidMotion pose =
        testing::look_at({6.0 * std::cos(turn), 6.0 * std::sin(turn), 1.0}, {0, 0, 0});
    project.views.push_back(testing::render(testing::sphere({0, 0, 0}, 1.0), camera, pose));
    project.views.back().name = "v" + std::to_string(i);
  }
  return project;
}

RigidMotion motion(double rx, double ry, double rz, double x, double y, double z) {
  return motion_from_tangent((RigidTangent() << rx, ry, rz, x, y, z).finished());
}

TEST(EvaluatePoses, ACommonMotionIsNoError) {
  const ScanProject truth = views_of_a_sphere(5);
  ScanProject result = truth;
  const RigidMotion common = motion(0.5, -1.0, 2.0, 3, 4, -5);
  for (RangeView& view : result.views) view.world_from_view = common * view.world_from_view;
  for (const bool robust : {false, true}) {
    const auto report = value_of(evaluate_poses(result, truth, {.robust = robust}));
    EXPECT_LT(report.max_rotation_deg, 1e-10);
    EXPECT_LT(report.max_displacement, 1e-12);
    EXPECT_TRUE(report.truth_from_result.isApprox(common.inverse(), 1e-12));
  }
}

TEST(EvaluatePoses, ReportsTheErrorOfAViewInAFixedWorld) {
  const ScanProject truth = views_of_a_sphere(3);
  ScanProject result = truth;
  result.views[1].world_from_view = motion(0, 0, 0, 0.3, 0, 0.4) * result.views[1].world_from_view;
  // About the view's own axis, through the sensor: its samples lie around that axis.
  result.views[2].world_from_view =
      result.views[2].world_from_view * motion(0, 0, 2.0 * kDegree, 0, 0, 0);
  const auto report = value_of(evaluate_poses(result, truth, {.fit_common_motion = false}));
  EXPECT_EQ(report.views[0].mean_displacement, 0.0);
  EXPECT_NEAR(report.views[1].translation, 0.5, 1e-12);
  EXPECT_NEAR(report.views[1].mean_displacement, 0.5, 1e-12);
  EXPECT_NEAR(report.views[1].rms_displacement, 0.5, 1e-12);
  EXPECT_NEAR(report.views[1].rotation_deg, 0.0, 1e-9);
  EXPECT_NEAR(report.views[2].rotation_deg, 2.0, 1e-9);
  EXPECT_LT(report.views[2].translation, 1e-3);
  EXPECT_GT(report.views[2].mean_displacement, 0.01);
  EXPECT_NEAR(report.max_translation, 0.5, 1e-12);
  EXPECT_NEAR(report.mean_rotation_deg, 2.0 / 3.0, 1e-9);
}

TEST(EvaluatePoses, RobustFitBlamesOnlyTheViewThatIsOff) {
  const ScanProject truth = views_of_a_sphere(6);
  ScanProject result = truth;
  result.views[3].world_from_view = motion(0, 0, 0, 1, 0, 0) * result.views[3].world_from_view;
  const auto squares = evaluate_poses(result, truth);
  const auto robust = evaluate_poses(result, truth, {.robust = true});
  ASSERT_TRUE(squares && robust);
  EXPECT_GT(squares->views[0].mean_displacement, 0.05);
  EXPECT_LT(robust->views[0].mean_displacement, 1e-3);
  EXPECT_NEAR(robust->views[3].mean_displacement, 1.0, 1e-3);
}

TEST(EvaluatePoses, FewSamplesStandForAView) {
  const ScanProject truth = views_of_a_sphere(3);
  ScanProject result = truth;
  result.views[1].world_from_view =
      motion(0, 0.01, 0, 0, 0, 0.02) * result.views[1].world_from_view;
  const auto all = evaluate_poses(result, truth);
  const auto some = evaluate_poses(result, truth, {.samples_per_view = 100});
  ASSERT_TRUE(all && some);
  EXPECT_NEAR(all->rms_displacement, some->rms_displacement, 0.05 * all->rms_displacement);
}

TEST(EvaluatePoses, LeavesOutViewsWithoutPose) {
  const ScanProject truth = views_of_a_sphere(4);
  ScanProject result = truth;
  result.views[2].pose = PoseKind::kAbsent;
  const auto report = value_of(evaluate_poses(result, truth));
  EXPECT_EQ(report.views.size(), 3u);
  EXPECT_EQ(report.unmatched, std::vector<std::string>{"v2"});
  for (RangeView& view : result.views) view.pose = PoseKind::kAbsent;
  EXPECT_THAT(evaluate_poses(result, truth), HasError(ErrorKind::kUnsolvable));
}

TEST(EvaluatePoses, NamesAViewWithoutTruth) {
  ScanProject result = views_of_a_sphere(2);
  result.views[1].name = "unknown";
  EXPECT_THAT(evaluate_poses(result, views_of_a_sphere(2)), HasError("unknown"));
}

}  // namespace
}  // namespace relief::evaluation
