#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/registration/align_views.h"
#include "relief/registration/calibrate_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/registration/calibration/spoiled_ring.h"
#include "tests/support/result_matchers.h"

namespace relief::registration {
namespace {

using ::testing::HasSubstr;
using testing::perturbed;

// Guesses are just under three degrees off.
const std::vector<RangeView>& guessed_ring() {
  static const std::vector<RangeView> views = [] {
    const auto truth = testing::ring_of_views();
    return perturbed(truth, Eigen::Vector3d::Zero(), 0.05, 2.0 * sample_spacing(truth[0]));
  }();
  return views;
}

const Alignment& aligned_ring() {
  static const Alignment aligned = align_views(guessed_ring()).value();
  return aligned;
}

RangeView copy_of(const RangeView& view, const RigidMotion& pose) {
  RangeView copy = view;
  copy.name += "_copy";
  copy.world_from_view = pose;
  return copy;
}

std::vector<RangeView> with_copy(std::vector<RangeView> views, RangeView copy) {
  views.push_back(std::move(copy));
  return views;
}

TEST(DistinctViews, ACopyCountsForNothingAndGetsThePose) {
  const Alignment& without = aligned_ring();
  const RangeView& copied = guessed_ring()[5];
  const auto views = with_copy(guessed_ring(), copy_of(copied, guessed_ring()[7].world_from_view));
  const Alignment aligned = value_of(align_views(views));
  ASSERT_EQ(aligned.views.size(), views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    const ViewReport& same = without.views[i < 8 ? i : 5];
    EXPECT_EQ(aligned.views[i].name, views[i].name);
    EXPECT_EQ(aligned.views[i].status, same.status);
    EXPECT_EQ(aligned.views[i].world_from_view.matrix(), same.world_from_view.matrix());
    EXPECT_EQ(aligned.views[i].pose_covariance, same.pose_covariance);
  }
  EXPECT_EQ(aligned.notes, without.notes);
  EXPECT_EQ(aligned.rms, without.rms);
  std::size_t of_copy = 0, of_original = 0;
  for (const PairFit& pair : aligned.pairs) {
    EXPECT_LT(pair.a, pair.b);
    EXPECT_FALSE(pair.a == 5 && pair.b == 8);
    of_original += pair.a == 5 || pair.b == 5 ? 1 : 0;
    of_copy += pair.b == 8 ? 1 : 0;
  }
  EXPECT_EQ(of_copy, of_original);
  EXPECT_EQ(aligned.pairs.size(), without.pairs.size() + of_copy);
}

// As where a file was copied over that of another view.
TEST(DistinctViews, TheGuessThatFitsIsTaken) {
  std::vector<RangeView> views = guessed_ring();
  views.insert(views.begin(), copy_of(views[5], views[2].world_from_view));
  AlignOptions options;
  options.starting_poses.search = false;
  const Alignment aligned = value_of(align_views(views, options));
  for (const ViewReport& view : aligned.views)
    EXPECT_EQ(view.status, PoseStatus::kVerified) << view.name << ": " << view.reason;
  const auto between = [](const Alignment& of, std::size_t a, std::size_t b) {
    return of.views[a].world_from_view.inverse() * of.views[b].world_from_view;
  };
  const RigidMotion off = between(aligned, 1, 6).inverse() * between(aligned_ring(), 0, 5);
  EXPECT_LT(off.translation().norm(), sample_spacing(views[0]));
}

TEST(DistinctViews, AKnownPoseOfACopyStays) {
  std::vector<RangeView> views = testing::ring_of_views();
  for (RangeView& view : views) view.pose = PoseKind::kKnown;
  const RigidMotion there = views[2].world_from_view;
  views = with_copy(views, copy_of(views[5], there));
  const Alignment aligned = value_of(align_views(views));
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(aligned.views[i].status, PoseStatus::kVerified);
  EXPECT_EQ(aligned.views[8].status, PoseStatus::kUnverified);
  EXPECT_THAT(aligned.views[8].reason, HasSubstr("its ranges are those of " + views[5].name));
  EXPECT_EQ(aligned.views[8].world_from_view.matrix(), there.matrix());
}

TEST(DistinctViews, CalibrationIsThatWithoutCopies) {
  const auto bend = [](std::size_t, int index) { return index == 2 ? 0.5 : 0.0; };
  const auto views = testing::spoiled(SensorError::kQuadraticWarp, bend);
  const auto copied = with_copy(views, copy_of(views[4], views[4].world_from_view));
  const auto calibrated = [](const std::vector<RangeView>& of) {
    return calibrate_views(of, align_views(of).value()).value();
  };
  const SensorCalibration without = calibrated(views), with = calibrated(copied);
  ASSERT_TRUE(with.found());
  ASSERT_EQ(with.views.size(), copied.size());
  EXPECT_EQ(with.deviation_after, without.deviation_after);
  for (std::size_t i = 0; i < with.views.size(); ++i)
    EXPECT_EQ(with.views[i].coefficients, without.views[i < views.size() ? i : 4].coefficients);
  auto corrected = copied;
  apply_calibration(with, corrected);
  const RangeView &original = corrected[4], &copy = corrected.back();
  EXPECT_EQ(copy.world_from_view.matrix(), original.world_from_view.matrix());
  for (int v = 0; v < copy.height(); ++v)
    for (int u = 0; u < copy.width(); ++u)
      if (copy.has_sample(u, v)) {
        EXPECT_EQ(copy.range(u, v), original.range(u, v));
      }
}

}  // namespace
}  // namespace relief::registration
