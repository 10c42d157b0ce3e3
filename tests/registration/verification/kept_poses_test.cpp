#include "registration/verification/kept_poses.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/pairwise/icp.h"
#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/result_matchers.h"

namespace relief::registration {
namespace {

using ::testing::Contains;
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
