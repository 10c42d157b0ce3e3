// Views of an object before a plane that is most of each: the plane fits wherever it is moved in
// itself, so the object has to tell how views lie.
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/global/features/planar_view.h"
#include "relief/registration/align_views.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::registration {
namespace {

using ::testing::HasSubstr;
using testing::Surface;
using testing::without_poses;

constexpr int kViews = 10;
constexpr double kRadius = 24.0;      // Of the object.
constexpr double kPlateHeight = -26;  // Below the object's centre: it stands on the plate.

// What is met first.
Surface nearer(const Surface& a, const Surface& b) {
  return [a, b](const Ray& ray) {
    const auto of_a = a(ray), of_b = b(ray);
    return of_a && (!of_b || of_a->t < of_b->t) ? of_a : of_b;
  };
}

// Sensors round the object, that look down on it.
RigidMotion sensor(int i) {
  const double angle = 2.0 * std::numbers::pi * i / kViews;
  return testing::look_at({200 * std::cos(angle), 200 * std::sin(angle), 110}, {0, 0, 0});
}

Surface plate() { return testing::plane({0, 0, kPlateHeight}, {0, 0, 1}); }

// A wall behind the object that stays where it is before the sensor.
Surface wall_of(const RigidMotion& sensor) {
  return testing::plane(sensor * Eigen::Vector3d(0, 0, 290),
                        sensor.linear() * Eigen::Vector3d(0.1, -0.2, -1).normalized());
}

RangeView view_of(const Surface& surface, int i) {
  const Camera camera = Camera::pinhole(140, 140, {300, 300, 69.5, 69.5});
  RangeView view = testing::render(surface, camera, sensor(i));
  view.name = "v" + std::to_string(i);
  testing::add_range_noise(view, 0.2, static_cast<std::uint32_t>(i + 1));
  return view;
}

TEST(ObjectOnPlate, TellsHowViewsLieThatAPlateFills) {
  std::vector<RangeView> views;
  for (int i = 0; i < kViews; ++i)
    views.push_back(view_of(nearer(testing::bumpy_object(kRadius), plate()), i));
  const auto aligned = value_of(align_views(without_poses(views)));
  for (const ViewReport& view : aligned.views)
    EXPECT_EQ(view.status, PoseStatus::kVerified) << view.name << ": " << view.reason;
  for (const double error :
       testing::mean_displacements(views, aligned.world_from_view(), testing::poses_of(views)))
    EXPECT_LT(error, 0.2 * sample_spacing(views[0]));
}

TEST(ObjectOnPlate, IsNotPlacedBeforeAWallThatStaysBehind) {
  std::vector<RangeView> views;
  for (int i = 0; i < 3; ++i)
    views.push_back(view_of(nearer(testing::bumpy_object(kRadius), wall_of(sensor(i))), i));
  for (const ViewReport& view : value_of(align_views(without_poses(views))).views) {
    EXPECT_FALSE(view.aligned) << view.name;
    EXPECT_THAT(view.reason, HasSubstr("the planes do not lie on each other")) << view.name;
  }
}

TEST(ObjectOnPlate, IsThePartOfItsViewsThatIsCompared) {
  std::vector<ViewSurface> surfaces;
  const RangeView on_plate = view_of(nearer(testing::bumpy_object(kRadius), plate()), 0);
  const RangeView plate_alone = view_of(plate(), 1);
  surfaces.emplace_back(on_plate);
  surfaces.emplace_back(plate_alone);
  const auto parts = without_dominant_planes(surfaces);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_GT(parts[0].samples().size(), 500u);
  for (const std::uint32_t i : parts[0].samples())
    EXPECT_GT((sensor(0) * parts[0].sample(i).point).z(), kPlateHeight + 5.0);
  EXPECT_LT(parts[0].radius(), 2.0 * kRadius);
  EXPECT_EQ(parts[1].samples().size(), surfaces[1].samples().size());
  surfaces.erase(surfaces.begin());
  EXPECT_TRUE(without_dominant_planes(surfaces).empty());
}

}  // namespace
}  // namespace relief::registration
