#include "relief/reconstruction/alignment_gain.h"

#include <gtest/gtest.h>

#include "tests/support/scenes/synthetic_views.h"

namespace relief::reconstruction {
namespace {

// An alignment of two views: the first is held, the centre of the second known to `deviation`.
registration::Alignment alignment_of(double rms, double deviation) {
  registration::Alignment alignment;
  alignment.rms = rms;
  alignment.termination = registration::RefinementTermination::kConverged;
  alignment.views.resize(2);
  for (auto& view : alignment.views) view.aligned = true;
  alignment.views[1].pose_covariance(3, 3) = deviation * deviation;
  return alignment;
}

const std::vector<RangeView> kNoSamples(2);

TEST(AlignmentGain, IsKeptWhereDeviationsFall) {
  const AlignmentGain gain =
      compare_alignments(alignment_of(0.2, 0.04), alignment_of(0.1, 0.03), kNoSamples);
  EXPECT_EQ(gain.verdict, GainVerdict::kGain);
  EXPECT_TRUE(gain.kept());
  EXPECT_DOUBLE_EQ(gain.first_pose_std, 0.04);
  EXPECT_DOUBLE_EQ(gain.second_pose_std, 0.03);
  EXPECT_EQ(gain.first_rms, 0.2);
  EXPECT_EQ(gain.second_rms, 0.1);
}

TEST(AlignmentGain, IsDroppedWhereDeviationsGrow) {
  const AlignmentGain gain =
      compare_alignments(alignment_of(0.2, 0.04), alignment_of(0.1, 0.05), kNoSamples);
  EXPECT_EQ(gain.verdict, GainVerdict::kNoGain);
  EXPECT_FALSE(gain.kept());
}

TEST(AlignmentGain, IsDroppedWhereTheSolverFailed) {
  registration::Alignment second = alignment_of(0.1, 0.0);
  second.termination = registration::RefinementTermination::kSolverFailed;
  EXPECT_EQ(compare_alignments(alignment_of(0.2, 0.04), second, kNoSamples).verdict,
            GainVerdict::kSolverFailed);
}

TEST(AlignmentGain, IsDroppedWhereAViewNoLongerFits) {
  registration::Alignment second = alignment_of(0.1, 0.01);
  second.views[1].aligned = false;
  const AlignmentGain gain = compare_alignments(alignment_of(0.2, 0.04), second, kNoSamples);
  EXPECT_EQ(gain.verdict, GainVerdict::kViewsLost);
  EXPECT_EQ(gain.left_out, 1u);
}

TEST(AlignmentGain, ViewsThatTheFirstAlignmentLeftOutTakeNoPart) {
  registration::Alignment first = alignment_of(0.2, 0.04);
  first.views.insert(first.views.begin(), registration::ViewReport{});
  const AlignmentGain gain = compare_alignments(first, alignment_of(0.1, 0.03), kNoSamples);
  EXPECT_TRUE(gain.kept());
  EXPECT_EQ(gain.left_out, 0u);
}

TEST(AlignmentGain, MeasuresHowFarSamplesMoved) {
  std::vector<RangeView> views(2);
  for (RangeView& view : views) {
    view.camera = Camera::orthographic(16, 16, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(),
                                       Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ());
    view.range = {16, 16, 5.0};
  }
  registration::Alignment second = alignment_of(0.1, 0.03);
  second.views[1].world_from_view.translation().x() = 0.3;
  const AlignmentGain gain = compare_alignments(alignment_of(0.2, 0.04), second, views);
  EXPECT_NEAR(gain.mean_motion, 0.15, 1e-12);
}

}  // namespace
}  // namespace relief::reconstruction
