#include "registration/given_poses/pose_convention.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class PoseConventionTest : public ::testing::Test {
 protected:
  static const std::vector<RangeView>& views() {
    static const auto ring = [] {
      auto views = testing::ring_of_views({.pixels = 96});
      // Beside the origin, so that the turntable differs from its inverse.
      for (RangeView& view : views)
        view.world_from_view = Eigen::Translation3d(300, -200, 500) * view.world_from_view;
      return views;
    }();
    return ring;
  }

  static PoseConvention find(const std::vector<RigidMotion>& poses) {
    std::vector<ViewSurface> surfaces;
    for (const RangeView& view : views()) surfaces.emplace_back(view);
    return find_pose_convention(surfaces, poses, std::vector<bool>(poses.size(), true));
  }

  // What a program writes whose poses are meant in this convention.
  static RigidMotion written(const PoseConvention& convention, const RigidMotion& world_from_view) {
    RigidMotion pose = world_from_view;
    pose.linear() = pose.linear() * convention.axes.transpose();
    if (convention.view_from_world) pose = pose.inverse();
    pose.translation() /= convention.unit;
    return pose;
  }
};

TEST_F(PoseConventionTest, TruePosesAreTakenAsGiven) {
  EXPECT_TRUE(find(testing::poses_of(views())).as_given());
}

TEST_F(PoseConventionTest, GuessesAreTakenAsGiven) {
  auto poses = testing::poses_of(views());
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses[i] = poses[i] * Eigen::AngleAxisd(i % 2 == 0 ? 0.04 : -0.04, Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(find(poses).as_given());
  EXPECT_TRUE(find(std::vector<RigidMotion>(poses.size(), RigidMotion::Identity())).as_given())
      << "all alike";
}

TEST_F(PoseConventionTest, NoUnitPutsAllViewsAtOnePlace) {
  // Views of one place alike, and guesses that put them apart.
  std::vector<ViewSurface> surfaces;
  for (int i = 0; i < 3; ++i) surfaces.emplace_back(views()[0]);
  std::vector<RigidMotion> poses(3, RigidMotion::Identity());
  for (std::size_t i = 0; i < 3; ++i) poses[i].translation().x() = 400.0 * static_cast<double>(i);
  EXPECT_TRUE(find_pose_convention(surfaces, poses, {true, true, true}).as_given());
}

// The front and the back of a round object share nothing. Read as view_from_world with the axes of
// OpenGL, exact poses of a turntable would lay them on each other.
TEST_F(PoseConventionTest, ViewsThatShareNothingAreTakenAsGiven) {
  const auto ring = testing::ring_of_views({.pixels = 112});
  std::vector<RangeView> opposite = {ring[0], ring[4]};
  const auto aligned = align_views(opposite);
  ASSERT_TRUE(aligned);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(aligned->views[i].status, PoseStatus::kUnverified);
    EXPECT_TRUE(aligned->views[i].world_from_view.isApprox(opposite[i].world_from_view, 1e-12));
  }
}

TEST_F(PoseConventionTest, OthersAreFound) {
  const Eigen::Matrix3d opencv = Eigen::Matrix3d::Identity();
  for (const PoseConvention& convention : {PoseConvention{1.0, true, opencv},
                                           {1.0, false, opengl_axes()},
                                           {1.0, true, opengl_axes()},
                                           {1000.0, false, opencv},
                                           {0.001, true, opencv},
                                           {0.001, false, opengl_axes()}}) {
    std::vector<RigidMotion> poses;
    for (const RigidMotion& pose : testing::poses_of(views()))
      poses.push_back(written(convention, pose));
    const PoseConvention found = find(poses);
    EXPECT_EQ(found.describe(), convention.describe());
    for (std::size_t i = 0; i < poses.size(); ++i)
      EXPECT_TRUE(found.world_from_view(poses[i]).isApprox(views()[i].world_from_view, 1e-12));
  }
}

TEST_F(PoseConventionTest, AlignmentTellsOfIt) {
  auto given = views();
  for (RangeView& view : given) view.world_from_view = view.world_from_view.inverse();
  const auto alignment = align_views(given);
  ASSERT_TRUE(alignment);
  EXPECT_TRUE(alignment->complete());
  EXPECT_THAT(alignment->notes, Contains(HasSubstr("taken as view_from_world")));
  const RigidMotion moved =
      alignment->views[3].world_from_view * views()[3].world_from_view.inverse();
  EXPECT_LT(
      (moved * views()[3].world_from_view.translation() - views()[3].world_from_view.translation())
          .norm(),
      2.0);
  AlignOptions trusting;
  trusting.starting_poses.given = GivenPoses::kTrust;
  const auto trusted = align_views(given, trusting);
  EXPECT_THAT(trusted->notes, Not(Contains(HasSubstr("taken as"))));
}

}  // namespace
}  // namespace relief::registration
