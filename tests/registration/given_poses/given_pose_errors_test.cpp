#include "registration/given_poses/given_pose_errors.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

class GivenPoseErrors : public ::testing::Test {
 protected:
  static const std::vector<RangeView>& ring() {
    static const auto views = testing::ring_of_views({.pixels = 64});
    return views;
  }
  static const std::vector<ViewSurface>& surfaces() {
    static const auto surfaces = [] {
      std::vector<ViewSurface> made;
      for (const RangeView& view : ring()) made.emplace_back(view);
      return made;
    }();
    return surfaces;
  }

  // All views at their true poses; the first `verified` are.
  static Alignment aligned(std::size_t verified) {
    Alignment alignment;
    for (std::size_t i = 0; i < ring().size(); ++i) {
      ViewReport view;
      view.world_from_view = ring()[i].world_from_view;
      view.aligned = true;
      view.status = i < verified ? PoseStatus::kVerified : PoseStatus::kUnverified;
      alignment.views.push_back(view);
    }
    return alignment;
  }

  // Of neighbours in the ring, deviating by so many standard deviations of their noise.
  static void add_pairs(double misfit, Alignment& alignment) {
    for (std::size_t a = 0; a + 1 < ring().size(); ++a) {
      PairFit pair;
      pair.a = a;
      pair.b = a + 1;
      pair.rms = misfit * joint_noise(surfaces()[a], surfaces()[a + 1]);
      alignment.pairs.push_back(pair);
    }
  }

  static std::vector<RangeView> with_poses(const auto& change) {
    std::vector<RangeView> views = ring();
    for (RangeView& view : views) view.world_from_view = change(view.world_from_view);
    return views;
  }
};

TEST_F(GivenPoseErrors, OtherReadingsAgree) {
  const auto inverse_rotations = with_poses([](RigidMotion pose) {
    pose.linear() = pose.linear().transpose().eval();
    return pose;
  });
  const auto inverses = with_poses([](const RigidMotion& pose) { return pose.inverse(); });
  for (const auto* views : {&inverse_rotations, &inverses}) {
    const auto found = agreeing_convention(*views, surfaces(), aligned(5), {});
    ASSERT_TRUE(found);
    const RigidMotion world =
        found->world_from_view((*views)[0].world_from_view) * ring()[0].world_from_view.inverse();
    for (std::size_t i = 0; i < views->size(); ++i)
      EXPECT_TRUE((world * ring()[i].world_from_view)
                      .isApprox(found->world_from_view((*views)[i].world_from_view), 1e-6))
          << i;
  }
}

TEST_F(GivenPoseErrors, NothingIsCorrectedWithoutEvidence) {
  const auto off = with_poses([](RigidMotion pose) {
    pose.translation() *= 1.2;
    return pose;
  });
  EXPECT_TRUE(agreeing_convention(off, surfaces(), aligned(5), {}));
  EXPECT_FALSE(agreeing_convention(off, surfaces(), aligned(2), {})) << "two views";
  EXPECT_FALSE(agreeing_convention(off, surfaces(), aligned(off.size()), {})) << "all verified";
  EXPECT_FALSE(agreeing_convention(ring(), surfaces(), aligned(5), {})) << "nothing is wrong";
  const auto hardly = with_poses([](RigidMotion pose) {
    pose.translation() *= 1.0001;
    return pose;
  });
  EXPECT_FALSE(agreeing_convention(hardly, surfaces(), aligned(5), {})) << "below the spacing";
  auto known = off;
  known[0].pose = PoseKind::kKnown;
  EXPECT_FALSE(agreeing_convention(known, surfaces(), aligned(5), {})) << "a known pose";
}

TEST_F(GivenPoseErrors, RefinementMovesFarWherePairsMoveAndDeviate) {
  int i = 0;
  const auto turned = with_poses([&](const RigidMotion& pose) {
    return pose * Eigen::AngleAxisd(0.4 * (i++ % 2), Eigen::Vector3d::UnitZ());
  });
  Alignment bad = aligned(8), good = bad;
  add_pairs(3.0, bad);
  add_pairs(1.2, good);
  EXPECT_TRUE(refinement_moved_far(turned, surfaces(), bad, {}))
      << "turned about the line of sight";
  EXPECT_FALSE(refinement_moved_far(turned, surfaces(), good, {}));
  EXPECT_FALSE(refinement_moved_far(ring(), surfaces(), bad, {}));
  const auto elsewhere =
      with_poses([](const RigidMotion& pose) { return Eigen::Translation3d(500, 0, 0) * pose; });
  EXPECT_FALSE(refinement_moved_far(elsewhere, surfaces(), bad, {})) << "the world moved";
  EXPECT_TRUE(fits_far_better(surfaces(), good, bad));
  EXPECT_FALSE(fits_far_better(surfaces(), bad, good));
}

TEST_F(GivenPoseErrors, HasFewDeterminedPairsWhereMoreAreDegenerateOrMisfit) {
  Alignment few = aligned(8), many = few;
  for (Alignment* alignment : {&few, &many}) add_pairs(1.0, *alignment);
  EXPECT_FALSE(has_few_determined_pairs(ring(), many));
  for (std::size_t i = 0; i < few.pairs.size(); ++i)
    few.pairs[i].status = i == 0       ? PairStatus::kThin
                          : i % 2 == 1 ? PairStatus::kDegenerate
                          : i % 4 == 0 ? PairStatus::kMisfit
                                       : PairStatus::kDetermined;
  EXPECT_TRUE(has_few_determined_pairs(ring(), few));
  EXPECT_TRUE(fits_far_better(surfaces(), many, few)) << "as small deviations, far more determined";
  EXPECT_FALSE(fits_far_better(surfaces(), few, many));
  for (PairFit& pair : many.pairs) pair.status = PairStatus::kThin;
  EXPECT_FALSE(has_few_determined_pairs(ring(), many)) << "they share little, but it fits";
  auto known = ring();
  known[0].pose = PoseKind::kKnown;
  EXPECT_FALSE(has_few_determined_pairs(known, few)) << "a known pose";
}

}  // namespace
}  // namespace relief::registration
