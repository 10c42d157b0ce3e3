#include "registration/given_poses/kept_poses.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/pairwise/icp.h"
#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/result_matchers.h"

namespace relief::registration {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

class KeptPoses : public ::testing::Test {
 protected:
  static const std::vector<RangeView>& views() {
    static const auto ring = testing::ring_of_views({.pixels = 112});
    return ring;
  }
  static const std::vector<ViewSurface>& surfaces() {
    static const auto made = [] {
      std::vector<ViewSurface> surfaces;
      for (const RangeView& view : views()) surfaces.emplace_back(view);
      return surfaces;
    }();
    return made;
  }
  static std::vector<RigidMotion> truth() { return testing::poses_of(views()); }
  static std::vector<ViewRole> free_roles() {
    return std::vector<ViewRole>(views().size(), ViewRole::kFree);
  }
  static std::vector<RigidMotion> off_by(double spacings) {
    return testing::poses_of(testing::perturbed(views(), Eigen::Vector3d::Zero(), 0.0,
                                                spacings * sample_spacing(views()[0])));
  }
  static bool fit_as_well(const std::vector<RigidMotion>& given,
                          const std::vector<RigidMotion>& refined) {
    const auto roles = free_roles();
    return GivenAndRefined(surfaces(), given, refined, roles, Association::kAuto)
        .given_fit_as_well();
  }
};

TEST_F(KeptPoses, TruePosesFitAsWellAsAnyOthers) {
  EXPECT_TRUE(fit_as_well(truth(), truth()));
  EXPECT_TRUE(fit_as_well(truth(), off_by(0.02)));
  EXPECT_TRUE(fit_as_well(truth(), off_by(0.5)));
}

TEST_F(KeptPoses, PosesThatErrDoNot) {
  for (const double spacings : {0.2, 0.5, 1.0, 4.0})
    EXPECT_FALSE(fit_as_well(off_by(spacings), truth())) << spacings;
}

TEST_F(KeptPoses, AViewMovedOffAllOthersIsLost) {
  auto refined = truth();
  refined[2].translation() += Eigen::Vector3d(0, 0, 4.0 * surfaces()[2].radius());
  std::vector<bool> expected(views().size(), false);
  expected[2] = true;
  const auto given = truth();
  auto roles = free_roles();
  const auto lost = [&] {
    return GivenAndRefined(surfaces(), given, refined, roles, Association::kAuto)
        .views_without_overlap();
  };
  EXPECT_THAT(lost(), ElementsAreArray(expected));
  roles[2] = ViewRole::kFixed;
  expected[2] = false;
  EXPECT_THAT(lost(), ElementsAreArray(expected));
}

TEST_F(KeptPoses, ViewsLaidOnEachOtherAreFound) {
  const auto given = truth();
  const auto roles = free_roles();
  const auto laid_at = [&](const std::vector<RigidMotion>& refined) {
    return GivenAndRefined(surfaces(), given, refined, roles, Association::kAuto)
        .coincident_views();
  };
  EXPECT_THAT(laid_at(truth()), ElementsAreArray(std::vector<bool>(views().size(), false)));
  auto refined = truth();
  refined[3] = refined[4];
  std::vector<bool> expected(views().size(), false);
  expected[3] = expected[4] = true;
  EXPECT_THAT(laid_at(refined), ElementsAreArray(expected));
}

// Views from all round that each show a flat wall before their sensor, which stands still with it.
std::vector<RangeView> views_of_a_still_wall() {
  constexpr int kViews = 8, kPixels = 64;
  const Camera camera = Camera::pinhole(kPixels, kPixels, {180, 180, 31.5, 31.5});
  const auto wall = testing::plane({0, 0, 330}, {0, 0, -1});
  std::vector<RangeView> views;
  for (int i = 0; i < kViews; ++i) {
    const double angle = 0.6 * i;
    views.push_back(testing::render(wall, camera));
    views.back().name = "view" + std::to_string(i);
    views.back().world_from_view =
        testing::look_at({300 * std::cos(angle), 300 * std::sin(angle), 40}, {0, 0, 0});
    testing::add_range_noise(views.back(), 0.3, static_cast<std::uint32_t>(i + 1));
  }
  return views;
}

TEST(StillWalls, ViewsLaidOnThemAreFound) {
  const auto views = views_of_a_still_wall();
  std::vector<ViewSurface> surfaces;
  for (const RangeView& view : views) surfaces.emplace_back(view);
  const auto given = testing::poses_of(views);
  const std::vector<RigidMotion> on_the_wall(views.size(), RigidMotion::Identity());
  std::vector<ViewRole> roles(views.size(), ViewRole::kFree);
  roles[2] = ViewRole::kFixed;
  const auto laid_at = [&](const std::vector<RigidMotion>& refined) {
    return GivenAndRefined(surfaces, given, refined, roles, Association::kAuto)
        .views_laid_on_planes({});
  };
  EXPECT_THAT(laid_at(given), Each(false));
  std::vector<bool> expected(views.size(), true);
  expected[2] = false;
  EXPECT_THAT(laid_at(on_the_wall), ElementsAreArray(expected));
}

TEST(StillWalls, GivenPosesAreKeptUnverified) {
  const auto views = views_of_a_still_wall();
  AlignOptions options;
  options.starting_poses.search = false;
  const auto aligned = value_of(align_views(views, options));
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(aligned.views[i].world_from_view.matrix(), views[i].world_from_view.matrix());
    EXPECT_EQ(aligned.views[i].status, PoseStatus::kUnverified);
    EXPECT_THAT(aligned.views[i].reason, HasSubstr("only a plane"));
  }
}

// What moves views far is no plane.
TEST_F(KeptPoses, ViewsMovedFarByMoreThanAPlaneAreNotLaidOnOne) {
  const auto given = testing::poses_of(testing::perturbed(views(), {0, 0, 0}, 0.8, 0.0));
  const auto refined = truth();
  const auto roles = free_roles();
  EXPECT_THAT(GivenAndRefined(surfaces(), given, refined, roles, Association::kAuto)
                  .views_laid_on_planes({}),
              Each(false));
}

// The poses of a robot or of a turntable: noise would move them by what it is.
TEST_F(KeptPoses, ExactPosesStayToTheBit) {
  const auto aligned = value_of(align_views(views()));
  for (std::size_t i = 0; i < views().size(); ++i) {
    EXPECT_EQ(aligned.views[i].world_from_view.matrix(), truth()[i].matrix());
    EXPECT_EQ(aligned.views[i].status, PoseStatus::kVerified);
    EXPECT_EQ(aligned.views[i].pose_std.isZero(0.0), i == 0);
  }
  EXPECT_THAT(aligned.notes, Contains(HasSubstr("given poses")));
}

}  // namespace
}  // namespace relief::registration
