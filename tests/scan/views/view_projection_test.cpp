#include "scan/views/view_projection.h"

#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

const Camera kPinhole = Camera::pinhole(64, 48, {80, 70, 30, 20});

// The same rays with nothing but a table to find them by.
Camera table_of(const Camera& camera) {
  Grid<Ray> rays(camera.width(), camera.height());
  for (int v = 0; v < camera.height(); ++v)
    for (int u = 0; u < camera.width(); ++u) rays(u, v) = camera.ray(u, v);
  return Camera::ray_table(std::move(rays), std::nullopt);
}

void expect_pixels_found(const Camera& camera) {
  const RangeView view = testing::render(testing::sphere({0, 0, 100}, 30), camera);
  const auto projection = value_of(ViewProjection::create(view));
  for (int v = 2; v < 46; v += 7) {
    for (int u = 2; u < 62; u += 9) {
      const auto pixel = projection.pixel_of(camera.ray(u, v).at(90.0));
      ASSERT_TRUE(pixel.has_value());
      EXPECT_LT((*pixel - Eigen::Vector2d(u, v)).norm(), 1e-6);
    }
  }
}

TEST(ViewProjection, FindsThePixelsOfCamerasAndOfTables) {
  expect_pixels_found(kPinhole);
  expect_pixels_found(table_of(kPinhole));
}

TEST(ViewProjection, FootprintsAreDistancesBetweenRays) {
  const auto projection = value_of(ViewProjection::create(
      testing::render(testing::sphere({0, 0, 100}, 30), table_of(kPinhole))));
  EXPECT_NEAR(projection.pixel_footprint(kPinhole.ray(30, 20).at(80.0), 30, 20), 1.0, 1e-9);
}

TEST(ViewProjection, ATableWithoutSamplesIsAnError) {
  RangeView view;
  view.name = "front";
  view.camera = table_of(kPinhole);
  view.range = Grid<double>(64, 48, kNoSample);
  EXPECT_THAT(ViewProjection::create(view), HasError(ErrorKind::kUnsolvable, "front"));
}

}  // namespace
}  // namespace relief
