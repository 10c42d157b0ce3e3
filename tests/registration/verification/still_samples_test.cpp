#include "registration/verification/still_samples.h"

#include <gtest/gtest.h>

#include "tests/support/scenes/synthetic_views.h"

namespace relief::registration {
namespace {

constexpr double kTolerance = 0.1;

RangeView wall(double z) {
  return testing::render(testing::plane({0, 0, z}, {0, 0, -1}),
                         Camera::pinhole(40, 30, {60, 60, 19.5, 14.5}));
}

double still_part(const RangeView& other, const RigidMotion& world_from_other, std::size_t count) {
  return still_fraction(wall(10.0), RigidMotion::Identity(),
                        std::vector<const RangeView*>(count, &other),
                        std::vector<RigidMotion>(count, world_from_other), kTolerance);
}

TEST(StillSamples, AreAtOnePlaceInTheCamerasFrameWherePosesMoveThem) {
  const RigidMotion turned(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()));
  EXPECT_DOUBLE_EQ(still_part(wall(10.0), turned, 3), 1.0);
  EXPECT_DOUBLE_EQ(still_part(wall(10.0), RigidMotion::Identity(), 3), 0.0);
  EXPECT_DOUBLE_EQ(still_part(wall(10.5), turned, 3), 0.0);
  // Of two views nothing tells which moved.
  EXPECT_DOUBLE_EQ(still_part(wall(10.0), turned, 1), 0.0);
}

}  // namespace
}  // namespace relief::registration
