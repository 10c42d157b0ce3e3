#include "registration/calibration/sensor_error_covariance.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/registration/align_views.h"
#include "scan/base/median.h"
#include "tests/registration/bumpy_object.h"
#include "tests/registration/calibration/spoiled_ring.h"

namespace relief::registration {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::spoiled;
using testing::true_ring;

Eigen::Vector3d mean_sample(const RangeView& view) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      sum += view.point(u, v);
      count += 1.0;
    }
  }
  return sum / count;
}

// The median over the views of how far a pose is from the true one, relative to the view that
// stays, over what its deviation says, with or without errors of the sensors.
struct ErrorOverDeviation {
  double with_sensors = 0.0, without_sensors = 0.0;
};

ErrorOverDeviation error_over_deviation(const Alignment& alignment) {
  const auto truth = testing::poses_of(true_ring());
  const RigidMotion frame = truth[0] * alignment.views[0].world_from_view.inverse();
  std::vector<double> with, without;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const ViewReport& view = alignment.views[i];
    const Eigen::Vector3d centre = mean_sample(true_ring()[i]);
    const double error = (frame * view.world_from_view * centre - truth[i] * centre).norm();
    const Vector6d all = view.pose_covariance.diagonal(),
                   sensors = view.sensor_covariance.diagonal();
    with.push_back(error / std::sqrt(all.tail<3>().sum()));
    without.push_back(error / std::sqrt((all - sensors).tail<3>().sum()));
  }
  return {median(with), median(without)};
}

TEST(SensorErrorCovariance, IsZeroForWhiteNoise) {
  const auto alignment =
      align_views(spoiled(SensorError::kRangeOffset, [](std::size_t, int) { return 0.0; })).value();
  for (const ViewReport& view : alignment.views) EXPECT_TRUE(view.sensor_covariance.isZero(0.0));
  EXPECT_EQ(alignment.sensor_error, "");
}

TEST(SensorErrorCovariance, ExplainsPosesThatASharedErrorMoved) {
  const auto alignment = align_views(spoiled(SensorError::kQuadraticWarp, [](std::size_t, int) {
                           return 0.4;
                         })).value();
  const ErrorOverDeviation ratio = error_over_deviation(alignment);
  EXPECT_GT(ratio.without_sensors, 3.0);
  EXPECT_GT(ratio.with_sensors, 0.5);
  EXPECT_LT(ratio.with_sensors, 2.0);
  EXPECT_THAT(alignment.sensor_error, HasSubstr("calibrating may correct it"));
}

// The ring as seen by a program that takes a range for `times` as much longer than the depth as the
// distance along the ray is.
std::vector<RangeView> bent_ring(double times) {
  auto views =
      testing::perturbed(true_ring(), Eigen::Vector3d::Zero(), 0.01, 0.5 * testing::spacing());
  for (RangeView& view : views)
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        view.range(u, v) *= 1.0 + times * (view.camera.ray(u, v).direction.norm() - 1.0);
  return views;
}

TEST(SensorErrorCovariance, NamesDistancesAlongTheRaysThatAreReadAsDepths) {
  const auto alignment = align_views(bent_ring(1.0)).value();
  EXPECT_THAT(alignment.sensor_error, HasSubstr("distances along the rays"));
  EXPECT_THAT(alignment.sensor_error, HasSubstr("\"kind\": \"ray\""));
}

TEST(SensorErrorCovariance, ABendOfAnotherSizeIsNotTakenForDistancesAlongTheRays) {
  const auto alignment = align_views(bent_ring(0.3)).value();
  EXPECT_THAT(alignment.sensor_error,
              AllOf(HasSubstr("an error like"), Not(HasSubstr("along the rays"))));
}

TEST(SensorErrorCovariance, ExplainsPosesThatErrorsOfEachViewMoved) {
  const auto alignment = align_views(spoiled(SensorError::kRangeOffset, [](std::size_t view, int) {
                           return 2.0 * std::sin(1.0 + 2.0 * static_cast<double>(view));
                         })).value();
  const ErrorOverDeviation ratio = error_over_deviation(alignment);
  EXPECT_GT(ratio.without_sensors, 3.0);
  EXPECT_GT(ratio.with_sensors, 0.5);
  EXPECT_LT(ratio.with_sensors, 2.0);
}

}  // namespace
}  // namespace relief::registration
