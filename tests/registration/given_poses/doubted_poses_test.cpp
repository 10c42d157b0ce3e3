#include "registration/verification/unsettled_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace relief::registration {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Matcher;

class UnsettledPoses : public ::testing::Test {
 protected:
  // Poses err by 0.05, and samples are 0.01 apart; the first view is held.
  UnsettledPoses() : views_(4) {
    aligned_.termination = RefinementTermination::kIterationLimit;
    aligned_.spacing = 0.01;
    aligned_.views.resize(views_.size());
    for (std::size_t i = 0; i < views_.size(); ++i) {
      aligned_.views[i].aligned = true;
      aligned_.views[i].status = PoseStatus::kVerified;
      views_[i].pose = PoseKind::kGuess;
      if (i > 0) aligned_.views[i].pose_std << 0, 0, 0, 0.03, 0.0, 0.04;
    }
  }

  std::size_t verified_after_a_last_motion_of(double motion) {
    Alignment doubted = aligned_;
    doubted.last_motion = motion;
    doubt_unsettled_poses(views_, doubted);
    std::size_t verified = 0;
    for (const ViewReport& view : doubted.views) {
      const bool kept = view.status == PoseStatus::kVerified;
      verified += kept ? 1 : 0;

      EXPECT_THAT(view.reason, kept ? Matcher<std::string>(IsEmpty()) : Matcher<std::string>(HasSubstr("did not settle")));
    }
    return verified;
  }

  std::vector<RangeView> views_;
  Alignment aligned_;
};

TEST_F(UnsettledPoses, AreThoseThatStillMoveByMoreThanTheyErrBy) {
  EXPECT_EQ(verified_after_a_last_motion_of(0.049), 4u);
  EXPECT_EQ(verified_after_a_last_motion_of(0.051), 0u);
}

TEST_F(UnsettledPoses, AreNoneWhereViewsMoveByLessThanASpacing) {
  aligned_.spacing = 0.1;
  EXPECT_EQ(verified_after_a_last_motion_of(0.09), 4u);
}

TEST_F(UnsettledPoses, AreNotThoseThatAreKnown) {
  views_[2].pose = PoseKind::kKnown;
  EXPECT_EQ(verified_after_a_last_motion_of(0.2), 1u);
}

TEST_F(UnsettledPoses, AreNoneWhereRefiningConverged) {
  aligned_.termination = RefinementTermination::kConverged;
  EXPECT_EQ(verified_after_a_last_motion_of(0.2), 4u);
}

}  // namespace
}  // namespace relief::registration
