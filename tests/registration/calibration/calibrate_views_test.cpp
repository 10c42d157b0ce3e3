#include "relief/registration/calibrate_views.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/calibration/model/sensor_model.h"
#include "tests/registration/bumpy_object.h"
#include "tests/registration/calibration/spoiled_ring.h"
#include "tests/support/result_matchers.h"

namespace relief::registration {
namespace {

using testing::mean_displacements;
using testing::perturbed;
using testing::poses_of;
using testing::sensors_of;
using testing::spacing;
using testing::spoiled;
using testing::true_ring;

SensorCalibration calibrated(const std::vector<RangeView>& views,
                             const CalibrationOptions& options = {}, const Context& context = {}) {
  return calibrate_views(views, align_views(views).value(), {}, options, context).value();
}

bool has_error(const SensorCalibration& calibration, SensorError error, bool per_view) {
  return std::any_of(calibration.errors.begin(), calibration.errors.end(), [&](const auto& found) {
    return found.error == error && found.per_view == per_view;
  });
}

double worst_pose(const Alignment& alignment) {
  const auto errors =
      mean_displacements(true_ring(), alignment.world_from_view(), poses_of(true_ring()));
  return *std::max_element(errors.begin(), errors.end()) / spacing();
}

// A bend of the ranges of every view: second and fourth term of the quadratic warp.
double shared_bend(std::size_t, int index) { return index == 2 ? 0.5 : index == 4 ? -0.4 : 0.0; }
double bend_of_view(std::size_t view, int index) {
  return index >= 2 ? 0.5 * std::sin(1.0 + 2.0 * static_cast<double>(view) + index) : 0.0;
}

// All views bent alike, and what is found of it.
struct BentRing {
  std::vector<RangeView> views = spoiled(SensorError::kQuadraticWarp, shared_bend);
  Alignment before = align_views(views).value();
  SensorCalibration calibration = calibrate_views(views, before).value();
};
const BentRing& bent_ring() {
  static const BentRing ring;
  return ring;
}

// Every view bent in its own way.
const std::vector<RangeView>& views_bent_apart() {
  static const std::vector<RangeView> views = spoiled(SensorError::kQuadraticWarp, bend_of_view);
  return views;
}

TEST(CalibrateViews, FindsNothingWhereThereIsNothing) {
  const auto views = perturbed(true_ring(), Eigen::Vector3d::Zero(), 0.01, 0.5 * spacing());
  const SensorCalibration calibration = calibrated(views);
  EXPECT_FALSE(calibration.found());
  EXPECT_GT(calibration.deviation_before, 0.0);
}

TEST(CalibrateViews, FindsABendThatAllViewsShare) {
  const auto& [views, before, calibration] = bent_ring();
  ASSERT_TRUE(has_error(calibration, SensorError::kQuadraticWarp, false));
  EXPECT_LT(calibration.deviation_after, 0.9 * calibration.deviation_before);
  EXPECT_LT(worst_pose(calibration.alignment), 0.3 * worst_pose(before));
  EXPECT_NE(before.sensor_error, "");
  EXPECT_EQ(calibration.alignment.sensor_error, "");
  const Sensors sensors = sensors_of(views);
  const SensorModel& model = sensors.models.front();
  for (std::size_t k = 0, index = 0; k < model.terms(); ++k) {
    if (model.error_of(k) != SensorError::kQuadraticWarp) continue;
    if (const double bend = shared_bend(0, static_cast<int>(index)); bend != 0.0) {
      EXPECT_NEAR(calibration.views[0].coefficients[k], -bend, 0.1) << "term " << index;
    }
    ++index;
  }
}

TEST(CalibrateViews, FindsABendOfEveryView) {
  const auto& views = views_bent_apart();
  const Alignment before = align_views(views).value();
  const SensorCalibration calibration = calibrated(views);
  EXPECT_TRUE(has_error(calibration, SensorError::kQuadraticWarp, true));
  EXPECT_LT(calibration.deviation_after, 0.7 * calibration.deviation_before);
  EXPECT_LT(calibration.alignment.rms, 0.7 * before.rms);
}

// Poses take up most of an offset: what is left between the views is a small part of it.
TEST(CalibrateViews, FindsAnOffsetOfSeveralSpacings) {
  constexpr double kOffset = 3.0;  // [sample spacings]
  const auto views = spoiled(SensorError::kRangeOffset, [](std::size_t, int) { return kOffset; });
  const SensorCalibration calibration = calibrated(views);
  ASSERT_EQ(calibration.errors.size(), 1u);
  EXPECT_EQ(calibration.errors[0].error, SensorError::kRangeOffset);
  EXPECT_FALSE(calibration.errors[0].per_view);
  const Sensors sensors = sensors_of(views);
  const SensorModel& model = sensors.models.front();
  for (std::size_t k = 0; k < model.terms(); ++k)
    if (model.error_of(k) == SensorError::kRangeOffset) {
      EXPECT_NEAR(calibration.views[0].coefficients[k], -kOffset, 0.1 * kOffset);
    }
}

// Bends of single views fit other places of these views, but not other views.
TEST(CalibrateViews, DoesNotTakeErrorsOfSingleViewsForThoseOfTheSensor) {
  EXPECT_FALSE(calibrated(views_bent_apart(), {.scope = CalibrationScope::kShared}).found());
}

TEST(CalibrateViews, HeedsTheScope) {
  const auto& views = views_bent_apart();
  EXPECT_FALSE(calibrated(views, {.scope = CalibrationScope::kOff}).found());
  for (const CalibratedError& error :
       calibrated(views, {.scope = CalibrationScope::kShared}).errors)
    EXPECT_FALSE(error.per_view);
}

// Without the bent view nothing is known of its error, and the others have none.
TEST(CalibrateViews, SaysWhatOtherViewsDoNotConfirm) {
  const auto views = spoiled(SensorError::kQuadraticWarp, [](std::size_t view, int index) {
    return view == 0 ? shared_bend(view, index) : 0.0;
  });
  const SensorCalibration calibration = calibrated(views);
  EXPECT_FALSE(calibration.found());
  EXPECT_THAT(calibration.notes,
              ::testing::Contains(::testing::HasSubstr("views err each in its own way")));
}

TEST(CalibrateViews, AppliesWhatItFound) {
  const SensorCalibration& calibration = bent_ring().calibration;
  auto views = bent_ring().views;
  apply_calibration(calibration, views);
  // The remaining error of the ranges, but for a constant: the pose takes that.
  const RangeView &truth = true_ring()[3], &corrected = views[3];
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (std::size_t i = 0; i < truth.range.size(); ++i) {
    if (!(truth.range[i] == truth.range[i])) continue;
    const double error = corrected.range[i] - truth.range[i];
    sum += error;
    squares += error * error;
    count += 1.0;
  }
  EXPECT_LT(std::sqrt(squares / count - std::pow(sum / count, 2)), 0.15 * spacing());
  EXPECT_EQ(views[3].world_from_view.matrix(),
            calibration.alignment.views[3].world_from_view.matrix());
}

TEST(CalibrateViews, WidensTheDeviationsOfPoses) {
  const SensorCalibration& calibration = bent_ring().calibration;
  double widest = 0.0;
  for (const ViewReport& view : calibration.alignment.views)
    widest = std::max(widest, view.pose_std.maxCoeff());
  EXPECT_GT(widest, 0.0);
  for (const CalibratedError& error : calibration.errors) EXPECT_GT(error.size_std, 0.0);
}

TEST(CalibrateViews, IsTheSameOnAnyNumberOfThreads) {
  const auto& [views, before, two] = bent_ring();
  const SensorCalibration one = calibrate_views(views, before, {}, {}, {.threads = 1}).value();
  ASSERT_TRUE(one.found());
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(one.views[i].coefficients, two.views[i].coefficients);
    EXPECT_EQ(one.alignment.views[i].world_from_view.matrix(),
              two.alignment.views[i].world_from_view.matrix());
  }
}

TEST(CalibrateViews, BringsBackViewsThatTheWrongSensorHadLost) {
  auto [views, before, unused] = bent_ring();
  constexpr std::size_t kLost = 4;
  before.views[kLost].aligned = false;
  before.views[kLost].status = PoseStatus::kLeftOut;
  std::erase_if(before.pairs,
                [&](const PairFit& pair) { return pair.a == kLost || pair.b == kLost; });
  const SensorCalibration calibration = calibrate_views(views, before).value();
  ASSERT_TRUE(calibration.found());
  EXPECT_EQ(calibration.alignment.views[kLost].status, PoseStatus::kVerified);
  EXPECT_LT(worst_pose(calibration.alignment), 0.3 * worst_pose(bent_ring().before));
  EXPECT_THAT(calibration.notes, ::testing::Contains(::testing::HasSubstr("aligned again")));
}

TEST(CalibrateViews, ReturnsToExactPosesThatTheWrongSensorLedAwayFrom) {
  auto views = bent_ring().views;
  for (std::size_t i = 0; i < views.size(); ++i)
    views[i].world_from_view = true_ring()[i].world_from_view;
  const Alignment before = align_views(views).value();
  ASSERT_GT(worst_pose(before), 0.05);
  const SensorCalibration calibration = calibrate_views(views, before).value();
  ASSERT_TRUE(calibration.found());
  for (std::size_t i = 0; i < views.size(); ++i)
    EXPECT_EQ(calibration.alignment.views[i].world_from_view.matrix(),
              views[i].world_from_view.matrix());
}

TEST(CalibrateViews, LeavesKnownPosesWhereTheyAre) {
  auto views = bent_ring().views;
  views[2].world_from_view = true_ring()[2].world_from_view;
  views[2].pose = PoseKind::kKnown;
  const SensorCalibration calibration = calibrated(views);
  ASSERT_TRUE(calibration.found());
  EXPECT_EQ(calibration.alignment.views[2].world_from_view.matrix(),
            true_ring()[2].world_from_view.matrix());
}

TEST(CalibrateViews, NeedsThreeViews) {
  const auto views = spoiled(SensorError::kQuadraticWarp, shared_bend);
  EXPECT_FALSE(calibrated({views[0], views[1]}).found());
}

TEST(CalibrateViews, RefusesWhatDoesNotBelongTogether) {
  EXPECT_THAT(calibrate_views(true_ring(), Alignment()), HasError(ErrorKind::kBadInput));
  EXPECT_THAT(calibrate_views(true_ring(), align_views(true_ring()).value(), {}, {.samples = 1}),
              HasError(ErrorKind::kBadInput));
}

TEST(CalibrateViews, StopsOnRequest) {
  const Alignment aligned = align_views(true_ring()).value();
  Context context;
  context.progress = [](double, std::string_view) { return false; };
  EXPECT_THAT(calibrate_views(true_ring(), aligned, {}, {}, context),
              HasError(ErrorKind::kInterrupted));
}

}  // namespace
}  // namespace relief::registration
