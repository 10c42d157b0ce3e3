#include "registration/given_poses/doubted_poses.h"

#include <gtest/gtest.h>

#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

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
      EXPECT_EQ(view.reason.find("did not settle") == std::string::npos, kept);
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

class UndeterminedPoses : public ::testing::Test {
 protected:
  UndeterminedPoses() : views_(testing::ring_of_views({.views = 4, .pixels = 48})) {
    for (RangeView& view : views_) {
      surfaces_.emplace_back(view);
      view.pose = PoseKind::kGuess;
      aligned_.views.push_back({.name = view.name,
                                .world_from_view = view.world_from_view,
                                .aligned = true,
                                .status = PoseStatus::kVerified});
    }
    for (std::size_t i = 1; i < views_.size(); ++i) aligned_.pairs.push_back({.a = i - 1, .b = i});
    aligned_.spacing = surfaces_[0].spacing();
  }

  std::vector<std::size_t> unverified() const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < views_.size(); ++i)
      if (aligned_.views[i].status == PoseStatus::kUnverified) found.push_back(i);
    return found;
  }

  void move(std::size_t i, double spacings) {
    aligned_.views[i].world_from_view.translation().x() += spacings * aligned_.spacing;
  }

  std::vector<RangeView> views_;
  std::vector<ViewSurface> surfaces_;
  Alignment aligned_;
};

TEST_F(UndeterminedPoses, AreThoseOfViewsThatNoPairHas) {
  doubt_undetermined_poses(views_, aligned_);
  EXPECT_TRUE(unverified().empty());
  aligned_.pairs.pop_back();
  doubt_undetermined_poses(views_, aligned_);
  EXPECT_EQ(unverified(), (std::vector<std::size_t>{3}));
}

TEST_F(UndeterminedPoses, AreThoseThatKeepAllMotions) {
  aligned_.views[1].kept_motions.resize(5);
  aligned_.views[2].kept_motions.resize(6);
  doubt_undetermined_poses(views_, aligned_);
  EXPECT_EQ(unverified(), (std::vector<std::size_t>{2}));
}

TEST_F(UndeterminedPoses, AViewThatMovedAndKeepsAMotionIsDoubted) {
  for (const std::size_t i : {1u, 2u}) aligned_.views[i].kept_motions.resize(1);
  move(1, 0.8);
  move(2, 1.2);
  doubt_kept_motions(views_, surfaces_, {}, aligned_);
  EXPECT_EQ(unverified(), (std::vector<std::size_t>{2}));
}

TEST_F(UndeterminedPoses, AViewThatKeepsAMotionIsDoubtedWhereOthersMoved) {
  aligned_.views[3].kept_motions.resize(1);
  for (const std::size_t i : {0u, 1u, 2u}) move(i, 1.2);
  doubt_kept_motions(views_, surfaces_, {}, aligned_);
  EXPECT_EQ(unverified(), (std::vector<std::size_t>{3}));
}

}  // namespace
}  // namespace relief::registration
