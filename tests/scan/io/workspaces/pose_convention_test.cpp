#include "scan/io/workspaces/rgbd/agreement/pose_convention.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scan/io/images/image_io.h"
#include "scan/io/workspaces/rgbd/agreement/depth_scale.h"
#include "scan/io/workspaces/rgbd/agreement/pose_scale.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::TemporaryFolder;

constexpr PinholeIntrinsics kIntrinsics{120, 120, 79.5, 59.5};

// A ball before a slanted wall, beside a smaller one: its mirror image is another scene.
std::optional<testing::SurfaceHit> scene(const Ray& ray) {
  static const std::vector<testing::Surface> parts = {testing::plane({0, 0, 4}, {0.3, 0.2, -1}),
                                                      testing::sphere({0.4, -0.2, 2.8}, 0.5),
                                                      testing::sphere({-0.7, 0.5, 3.2}, 0.3)};
  std::optional<testing::SurfaceHit> nearest;
  for (const testing::Surface& part : parts)
    if (const auto hit = part(ray); hit && (!nearest || hit->t < nearest->t)) nearest = hit;
  return nearest;
}

// Five views of the scene, their depth maps in files. What `still` says is put before all of them.
class PoseConventions : public ::testing::Test {
 protected:
  // Turned by `turn` of what they are else.
  void write_views(float still = 0.0f, double turn = 1.0) {
    const Camera camera = Camera::pinhole(160, 120, kIntrinsics);
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector3d eye(0.35 * i - 0.6, 0.1 * i * i - 0.8, 0.3 * std::sin(2.0 * i));
      const RigidMotion pose = testing::look_at(
          eye,
          turn * Eigen::Vector3d(0.1 * i, 0, 3) + (1.0 - turn) * (eye + Eigen::Vector3d(0, 0, 3)),
          Eigen::Vector3d(0.3 * turn * std::cos(i), -1, 0));
      add_view(testing::render(scene, camera, pose), still);
    }
  }

  void add_view(const RangeView& view, float still = 0.0f) {
    Image depth(view.width(), view.height(), 1, 65535);
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        if (view.has_sample(u, v) || still > 0.0f)
          depth(u, v) = still > 0.0f && u > 60 ? still : std::round(1000.0f * view.range(u, v));
    ViewSpec spec;
    spec.name = std::to_string(project_.views.size());
    spec.depth = DepthSpec{folder_.write(spec.name + ".png", *encode_png(depth)), 0.001, false};
    spec.camera.emplace();
    spec.camera->intrinsics = kIntrinsics;
    spec.world_from_view = view.world_from_view;
    spec.pose = PoseKind::kGuess;
    project_.views.push_back(std::move(spec));
  }

  // The same views with their poses stored in a convention.
  ProjectSpec stored(const PoseConvention& convention) const {
    ProjectSpec project = project_;
    for (ViewSpec& view : project.views) {
      RigidMotion& pose = view.world_from_view;
      pose.linear() = pose.linear() * convention.axes.transpose();
      if (convention.axes.determinant() < 0.0) {
        const Eigen::Vector3d mirror(1, -1, 1);
        pose.linear() = mirror.asDiagonal() * pose.linear();
        pose.translation() = mirror.asDiagonal() * pose.translation();
      }
      if (convention.view_from_world) pose = pose.inverse();
      pose.translation() /= convention.unit;
      const Eigen::Quaterniond q(pose.linear());
      if (convention.rotation == StoredRotation::kInverse)
        pose.linear().transposeInPlace();
      else if (convention.rotation == StoredRotation::kQuaternionWFirst)
        pose.linear() = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();
    }
    return project;
  }

  // Of the poses of the views relative to the first: the largest entry.
  double difference(const ProjectSpec& project) const {
    double largest = 0.0;
    const auto relative = [](const ProjectSpec& of, std::size_t i) {
      return of.views[0].world_from_view.inverse() * of.views[i].world_from_view;
    };
    for (std::size_t i = 1; i < project.views.size(); ++i)
      largest = std::max(
          largest,
          (relative(project, i).matrix() - relative(project_, i).matrix()).cwiseAbs().maxCoeff());
    return largest;
  }

  TemporaryFolder folder_;
  ProjectSpec project_;
};

TEST_F(PoseConventions, AreFoundWhicheverTheyAre) {
  write_views();
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      for (const bool view_from_world : {false, true}) {
        PoseConvention convention{1.0, view_from_world, Eigen::Matrix3d::Zero()};
        for (int i = 0; i < 3; ++i)
          convention.axes(i, order[static_cast<std::size_t>(i)]) = (signs >> i) % 2 ? -1.0 : 1.0;
        ProjectSpec project = stored(convention);
        take_pose_convention(project, ComparedDepths(project));
        EXPECT_LT(difference(project), 1e-9) << convention.axes << view_from_world;
        const bool as_stated = !view_from_world && convention.axes.isIdentity();
        EXPECT_EQ(project.notes.empty(), as_stated);
        note_disagreement_at_poses(project, ComparedDepths(project));
        EXPECT_EQ(project.notes.size(), as_stated ? 0u : 1u);
      }
    }
  } while (std::next_permutation(order.begin(), order.end()));
}

// The front and the back of a body share nothing. Stored poses of a turntable that are read the
// wrong way would lay them on each other.
TEST_F(PoseConventions, OfViewsThatShareNothingStay) {
  const auto three_balls = [](const Ray& ray) {
    std::optional<testing::SurfaceHit> nearest;
    for (const double height : {-0.6, 0.0, 0.6})
      if (const auto hit = testing::sphere({0, 0, height}, height == 0.0 ? 0.5 : 0.3)(ray);
          hit && (!nearest || hit->t < nearest->t))
        nearest = hit;
    return nearest;
  };
  for (const double x : {-3.0, 3.0})
    add_view(testing::render(three_balls, Camera::pinhole(160, 120, kIntrinsics),
                             testing::look_at({x, 0, 0}, {0, 0, 0}, {0, 0, 1})));
  ProjectSpec project = project_;
  take_pose_convention(project, ComparedDepths(project));
  EXPECT_THAT(project.notes, IsEmpty());
  EXPECT_EQ(difference(project), 0.0);
}

TEST_F(PoseConventions, OfOtherUnitsAreFound) {
  write_views();
  for (const double unit : {0.001, 0.01, 100.0, 1000.0}) {
    PoseConvention convention;
    convention.unit = unit;
    convention.view_from_world = unit < 1.0;
    ProjectSpec project = stored(convention);
    take_pose_convention(project, ComparedDepths(project));
    EXPECT_LT(difference(project), 1e-9) << unit;
    EXPECT_EQ(project.notes.size(), 1u);
  }
}

TEST_F(PoseConventions, OfOtherRotationsAreFound) {
  write_views();
  for (const auto rotation : {StoredRotation::kInverse, StoredRotation::kQuaternionWFirst})
    for (const bool view_from_world : {false, true})
      for (const bool opengl : {false, true}) {
        PoseConvention convention{1.0, view_from_world, Eigen::Matrix3d::Identity(), rotation};
        if (opengl) convention.axes = opengl_axes();
        ProjectSpec project = stored(convention);
        take_pose_convention(project, ComparedDepths(project));
        EXPECT_LT(difference(project), 1e-9) << convention.describe();
        EXPECT_THAT(project.notes, ElementsAre(HasSubstr(convention.describe())));
      }
}

// As on a slider: the inverse of a small turn agrees nearly as well.
TEST_F(PoseConventions, OfCamerasThatHardlyTurnAreFound) {
  write_views(0.0f, 0.01);
  PoseConvention opengl;
  opengl.axes = opengl_axes();
  ProjectSpec project = stored(opengl);
  take_pose_convention(project, ComparedDepths(project));
  EXPECT_LT(difference(project), 1e-9);
}

TEST_F(PoseConventions, TellTheScaleOfTheDepthToo) {
  write_views();
  PoseConvention w_first;
  w_first.rotation = StoredRotation::kQuaternionWFirst;
  for (const auto& convention : {PoseConvention(), w_first}) {
    ProjectSpec project = stored(convention);
    for (ViewSpec& view : project.views) view.depth->scale = 1.0;
    const auto assumed = assume_depth_scale(project, 5000.0, ComparedDepths(project));
    ASSERT_TRUE(assumed);
    EXPECT_EQ(assumed->metres_per_value, 0.001);
    EXPECT_THAT(assumed->note, HasSubstr(convention.as_given() ? "agree at their poses"
                                                               : "in another convention"));
  }
}

TEST_F(PoseConventions, OfImagesAloneGetTheirScale) {
  write_views();
  for (const double scale : {1.0, 0.21, 7.3}) {
    ProjectSpec project = project_;
    for (ViewSpec& view : project.views) view.world_from_view.translation() *= scale;
    take_pose_scale(project, ComparedDepths(project));
    EXPECT_LT(difference(project), scale == 1.0 ? 1e-12 : 0.01) << scale;
    EXPECT_EQ(project.notes.size(), scale == 1.0 ? 0u : 1u);
  }
}

TEST_F(PoseConventions, AreFoundBesideWhatStandsStill) {
  write_views(900.0f);
  PoseConvention forward_left_up;
  forward_left_up.axes << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  ProjectSpec project = stored(forward_left_up);
  take_pose_convention(project, ComparedDepths(project));
  EXPECT_LT(difference(project), 1e-9);
  EXPECT_THAT(project.notes, Contains(HasSubstr("x forward, y left, z up")));
}

TEST_F(PoseConventions, AreToldInTheAxesOfTheFormat) {
  write_views();
  PoseConvention opencv;  // Of a format with y up and z back.
  opencv.axes = opengl_axes();
  ProjectSpec project = stored(opencv);
  take_pose_convention(project, ComparedDepths(project), opengl_axes());
  EXPECT_THAT(project.notes, Contains(HasSubstr("taken as world_from_view: ")));
}

TEST_F(PoseConventions, OfLeftHandedWorldsReverseY) {
  write_views();
  PoseConvention unity;
  unity.axes = Eigen::Vector3d(1, -1, 1).asDiagonal();
  ProjectSpec project = stored(unity);
  take_pose_convention(project, ComparedDepths(project));
  EXPECT_THAT(project.notes, Contains(AllOf(HasSubstr("x right, y up, z forward"),
                                            HasSubstr("left-handed world (its y is reversed)"))));
  EXPECT_TRUE(project.views[3].world_from_view.isApprox(project_.views[3].world_from_view));
}

TEST_F(PoseConventions, PosesOfOtherViewsAreOnlyTold) {
  write_views();
  ProjectSpec project = project_;
  for (std::size_t i = 0; i < 5; ++i)
    project.views[i].world_from_view = project_.views[(2 * i + 1) % 5].world_from_view;
  const ProjectSpec before = project;
  take_pose_convention(project, ComparedDepths(project));
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_TRUE(project.views[i].world_from_view.isApprox(before.views[i].world_from_view, 0.0));
  note_disagreement_at_poses(project, ComparedDepths(project));
  EXPECT_THAT(project.notes, ::testing::ElementsAre(HasSubstr("disagree at their poses by")));
}

TEST_F(PoseConventions, ViewsWithoutPosesTellNothing) {
  write_views();
  ProjectSpec project = project_;
  for (ViewSpec& view : project.views) view.pose = PoseKind::kAbsent;
  take_pose_convention(project, ComparedDepths(project));
  note_disagreement_at_poses(project, ComparedDepths(project));
  EXPECT_THAT(project.notes, IsEmpty());
}

}  // namespace
}  // namespace relief
