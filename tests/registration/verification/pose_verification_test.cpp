#include "registration/verification/pose_verification.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/registration/align_views.h"
#include "relief/scan/context.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/result_matchers.h"

namespace relief::registration {
namespace {

class PoseVerificationTest : public ::testing::Test {
 protected:
  static const std::vector<RangeView>& views() {
    static const auto ring = testing::ring_of_views({.pixels = 112});
    return ring;
  }

  static std::vector<ViewSurface> surfaces_of(const std::vector<RangeView>& of) {
    std::vector<ViewSurface> surfaces;
    for (const RangeView& view : of) surfaces.emplace_back(view);
    return surfaces;
  }

  static PoseVerification verify(const std::vector<RangeView>& of,
                                 const std::vector<RigidMotion>& poses, int threads = 0) {
    return on_threads(threads, [&] {
      return verify_poses(surfaces_of(of), poses, std::vector<ViewRole>(of.size(), ViewRole::kFree),
                          {});
    });
  }
};

TEST_F(PoseVerificationTest, TruePosesConfirmEachOther) {
  const auto verified = verify(views(), testing::poses_of(views()));
  for (std::size_t i = 0; i < views().size(); ++i) {
    EXPECT_EQ(verified.group[i], 0u);
    EXPECT_FALSE(verified.views[i].refuted);
    EXPECT_EQ(verified.views[i].violation, 0.0);
    EXPECT_GT(verified.views[i].support, 0.3);
  }
}

TEST_F(PoseVerificationTest, TheOneWrongViewIsRefutedAndNoOther) {
  for (const std::size_t wrong : {0u, 3u, 7u}) {
    auto poses = testing::poses_of(views());
    poses[wrong] = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()) * poses[wrong];
    const auto verified = verify(views(), poses);
    for (std::size_t i = 0; i < views().size(); ++i)
      EXPECT_EQ(verified.views[i].refuted, i == wrong) << wrong << ", " << i;
    EXPECT_EQ(verified.group[wrong], wrong);
  }
}

// Poses that are all wrong deviate alike, as noisy views do, but by more in a wider reach.
TEST_F(PoseVerificationTest, PosesThatAreAllWrongDoNotConfirmEachOther) {
  for (const double seed : {0.0, 1.0, 2.0}) {
    auto poses = testing::poses_of(views());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double phase = 2.0 * static_cast<double>(i);
      poses[i] =
          Eigen::Translation3d(4.0 * sample_spacing(views()[i]) *
                               Eigen::Vector3d(std::cos(phase + seed), std::sin(2.0 * phase + seed),
                                               std::cos(3.0 * phase + seed))) *
          poses[i];
    }
    const auto verified = verify(views(), poses);
    for (std::size_t i = 0; i < views().size(); ++i) EXPECT_EQ(verified.group[i], i) << seed;
  }
}

// A wall seen from afar, by a sensor whose errors grow with the square of the distance.
TEST_F(PoseVerificationTest, TheWrongViewIsRefutedWhereAPartOfAllViewsIsFarAway) {
  auto before_wall = views();
  for (RangeView& view : before_wall) {
    for (int v = 0; v < 12; ++v)
      for (int u = 0; u < view.width(); ++u) view.range(u, v) = 9000.0 + 30.0 * u + 50.0 * v;
    for (double& range : view.range) range = 1.0 / (std::round(1.0 / range / 5e-6) * 5e-6);
  }
  auto poses = testing::poses_of(views());
  poses[3] = poses[3] * Eigen::Translation3d(0, 0, -8);  // Five spacings towards its sensor.
  const auto verified = verify(before_wall, poses);
  for (std::size_t i = 0; i < views().size(); ++i)
    EXPECT_EQ(verified.views[i].refuted, i == 3) << i;
}

TEST_F(PoseVerificationTest, AViewThatIsOffDeviatesAloneAndNoisyOnesDoNot) {
  const auto deviating = [](const std::vector<RangeView>& of,
                            const std::vector<RigidMotion>& poses) {
    std::vector<bool> result;
    for (const ViewVerification& view : verify(of, poses).views)
      result.push_back(view.deviates_alone);
    return result;
  };
  const std::vector<bool> none(views().size(), false);
  auto poses = testing::poses_of(views());
  EXPECT_EQ(deviating(views(), poses), none);
  auto noisy = views();
  testing::add_range_noise(noisy[3], 1.5 * sample_spacing(noisy[3]), 99);
  EXPECT_EQ(deviating(noisy, poses), none);
  poses[3] = poses[3] * Eigen::Translation3d(0, 0, 2.0 * sample_spacing(views()[3]));
  auto expected = none;
  expected[3] = true;
  EXPECT_EQ(deviating(views(), poses), expected);
}

// Its ranges are bent as those of no other view.
TEST_F(PoseVerificationTest, AViewThatDeviatesAloneIsUnverified) {
  auto of = testing::ring_of_views({.pixels = 112, .noise = 0.05});
  const double size = 0.3 * sample_spacing(of[3]);
  for (int v = 0; v < of[3].height(); ++v)
    for (int u = 0; u < of[3].width(); ++u)
      of[3].range(u, v) += size * std::sin(u / 1.5) * std::cos(v / 1.5);
  const auto aligned = value_of(align_views(of));
  for (std::size_t i = 0; i < of.size(); ++i)
    EXPECT_EQ(to_string(aligned.views[i].status), i == 3 ? "unverified" : "verified") << i;
  EXPECT_THAT(aligned.views[3].reason, ::testing::HasSubstr("more than any two others"));
}

TEST_F(PoseVerificationTest, FixedViewsAreNeverRefuted) {
  auto poses = testing::poses_of(views());
  poses[2] = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()) * poses[2];
  std::vector<ViewRole> roles(views().size(), ViewRole::kFree);
  roles[2] = ViewRole::kFixed;
  EXPECT_FALSE(verify_poses(surfaces_of(views()), poses, roles).views[2].refuted);
}

// A laser and a camera lose what either does not see: at right poses half of what one view faces
// may be missing in the other.
TEST_F(PoseVerificationTest, MissingSamplesRefuteNothing) {
  auto shadowed = views();
  for (std::size_t i = 0; i < shadowed.size(); i += 2)
    for (int v = 0; v < shadowed[i].height(); ++v)
      for (int u = 0; u < shadowed[i].width() / 2; ++u) shadowed[i].range(u, v) = kNoSample;
  const auto verified = verify(shadowed, testing::poses_of(views()));
  for (std::size_t i = 0; i < shadowed.size(); ++i) {
    EXPECT_FALSE(verified.views[i].refuted);
    EXPECT_EQ(verified.group[i], 0u);
  }
}

// Sensors that smooth their ranges show little noise, and err smoothly by many times as much: then
// all pairs disagree at right poses.
class SmoothErrorsTest : public PoseVerificationTest {
 protected:
  static std::vector<RangeView> smoothly_wrong(double spacings = 5.0) {
    auto wrong = views();
    for (std::size_t i = 0; i < wrong.size(); ++i) {
      const double size = spacings * sample_spacing(wrong[i]), phase = 1.7 * static_cast<double>(i);
      for (int v = 0; v < wrong[i].height(); ++v)
        for (int u = 0; u < wrong[i].width(); ++u)
          wrong[i].range(u, v) +=
              size * std::sin(u / 5.0 + phase) * std::cos(v / 6.0 + 2.0 * phase);
    }
    return wrong;
  }
};

TEST_F(SmoothErrorsTest, RefuteNoView) {
  const auto verified = verify(smoothly_wrong(), testing::poses_of(views()));
  for (const ViewVerification& view : verified.views) EXPECT_FALSE(view.refuted);
}

// Of more than the reach within which partners are looked for at first, four spacings, so that what
// is found there does not show how large they are.
TEST_F(SmoothErrorsTest, BeyondTheFirstReachRefuteNoView) {
  const auto verified = verify(smoothly_wrong(8.0), testing::poses_of(views()));
  for (const ViewVerification& view : verified.views) EXPECT_FALSE(view.refuted);
}

TEST_F(SmoothErrorsTest, HideNoViewThatIsFarOff) {
  auto poses = testing::poses_of(views());
  poses[3] = poses[3] * Eigen::Translation3d(0, 0, -40);  // Towards its sensor.
  const auto verified = verify(smoothly_wrong(), poses);
  for (std::size_t i = 0; i < views().size(); ++i)
    EXPECT_EQ(verified.views[i].refuted, i == 3) << i;
}

// Views from above of a floor, each half a view beside the one before.
class FloorTest : public PoseVerificationTest {
 protected:
  static constexpr int kWidth = 100, kHeight = 60;

  static std::vector<RangeView> floor() {
    std::vector<RangeView> views(4);
    for (std::size_t i = 0; i < views.size(); ++i) {
      views[i].camera =
          Camera::orthographic(kWidth, kHeight, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
      views[i].range = Grid<double>(kWidth, kHeight, 200.0);
      views[i].world_from_view = Eigen::Translation3d(50.0 * static_cast<double>(i), 0, 0);
    }
    return views;
  }

  // A part of a view stands in front of the floor: the columns from `first`.
  static void raise(RangeView& view, int first) {
    for (int v = 10; v < 50; ++v)
      for (int u = first; u < first + 20; ++u) view.range(u, v) = 180.0;
  }

  static std::vector<bool> refuted(const std::vector<RangeView>& views) {
    const auto verified = verify(views, testing::poses_of(views));
    std::vector<bool> result;
    for (const ViewVerification& view : verified.views) result.push_back(view.refuted);
    return result;
  }
};

TEST_F(FloorTest, AViewThatOneAllowsStaysThoughAnotherContradictsIt) {
  auto views = floor();
  raise(views[1], 70);  // Where view 2 sees the floor, and view 0 nothing.
  EXPECT_EQ(refuted(views), std::vector<bool>({false, false, false, false}));
}

TEST_F(FloorTest, AViewThatAllContradictIsRefuted) {
  auto views = floor();
  raise(views[1], 15);
  raise(views[1], 70);
  EXPECT_EQ(refuted(views), std::vector<bool>({false, true, false, false}));
}

TEST_F(PoseVerificationTest, ViewsThatMeetNothingAreNeitherConfirmedNorRefuted) {
  auto poses = testing::poses_of(views());
  poses[5] = Eigen::Translation3d(1e4, 0, 0) * poses[5];
  const auto verified = verify(views(), poses);
  EXPECT_FALSE(verified.views[5].refuted);
  EXPECT_FALSE(verified.views[5].overlaps);
  EXPECT_EQ(verified.group[5], 5u);
}

TEST_F(PoseVerificationTest, DoesNotDependOnTheThreadCount) {
  const auto poses = testing::poses_of(views());
  const auto one = verify(views(), poses, 1), three = verify(views(), poses, 3);
  for (std::size_t i = 0; i < views().size(); ++i)
    EXPECT_EQ(one.views[i].support, three.views[i].support);
}

}  // namespace
}  // namespace relief::registration
