#include "relief/rendering/picture_camera.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "scan/base/counter_random.h"
#include "tests/scan/rendering/shapes.h"

namespace relief::rendering {
namespace {

using testing::sphere;

// Without symmetry, far from the origin.
TriangleMesh cloud() {
  const CounterRandom random(3, 4);
  TriangleMesh mesh;
  for (std::uint64_t i = 0; i < 200; ++i)
    mesh.vertices.emplace_back(100.0 + 30.0 * random.uniform(3 * i),
                               -50.0 + 5.0 * random.uniform(3 * i + 1),
                               9.0 * random.uniform(3 * i + 2));
  return mesh;
}

// The pixels of the vertices [pixels].
Eigen::AlignedBox2d picture_box(const TriangleMesh& mesh, const PictureCamera& camera) {
  Eigen::AlignedBox2d box;
  for (const auto& vertex : mesh.vertices) {
    const auto pixel = camera.camera.project(camera.world_from_camera.inverse() * vertex);
    EXPECT_TRUE(pixel);
    if (pixel) box.extend(*pixel);
  }
  return box;
}

void expect_fits(const FramingOptions& options, const ViewingDirection& direction) {
  const Eigen::AlignedBox2d box = picture_box(cloud(), frame_mesh(cloud(), direction, options));
  const Eigen::Array2d size(options.width, options.height);
  const Eigen::Array2d left = (box.min().array() + 0.5) / size;
  const Eigen::Array2d right = 1.0 - (box.max().array() + 0.5) / size;
  // It touches the margin on both sides in one direction, and keeps it in the other.
  const int tight = left[0] < left[1] ? 0 : 1;
  EXPECT_NEAR(left[tight], options.margin, 1e-9);
  EXPECT_NEAR(right[tight], options.margin, 1e-9);
  EXPECT_GE(std::min(left[1 - tight], right[1 - tight]), options.margin - 1e-9);
}

TEST(FrameMesh, FillsThePictureUpToTheMarginFromAnySide) {
  for (const ViewingDirection& direction :
       {ViewingDirection{0, 0, 0}, ViewingDirection{30, 20, 0}, ViewingDirection{250, -70, 40}}) {
    expect_fits({.width = 300, .height = 200}, direction);
    expect_fits({.width = 120, .height = 480, .field_of_view_deg = 70.0}, direction);
    expect_fits({.width = 300, .height = 300, .field_of_view_deg = 0.0, .margin = 0.1}, direction);
  }
}

TEST(FrameMesh, AnglesAreAsTheirNamesSay) {
  // The viewer's place beside the middle, right and up of the picture.
  const auto check = [](const ViewingDirection& direction, const Eigen::Vector3d& towards,
                        const Eigen::Vector3d& right, const Eigen::Vector3d& up_axis) {
    const PictureCamera camera =
        frame_mesh(sphere(1.0), direction, {.width = 51, .height = 51, .up = up_axis});
    EXPECT_LT((camera.picture_axes().row(2).transpose() - towards).norm(), 1e-6);
    EXPECT_LT((camera.picture_axes().row(0).transpose() - right).norm(), 1e-6);
    EXPECT_NEAR(camera.picture_axes().determinant(), 1.0, 1e-9);
  };
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ();
  check({0, 0, 0}, -y, x, z);
  check({90, 0, 0}, x, y, z);
  check({0, 90, 0}, z, x, z);
  check({0, 0, 90}, -y, -z, z);  // The camera turned clockwise: its right side is below.
  check({0, 0, 0}, z, x, y);
  check({0, 90, 0}, y, x, y);
}

TEST(FrameMesh, LooksFromWhereItIsTold) {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  for (const Eigen::Vector3d& up : {z, Eigen::Vector3d(-z), Eigen::Vector3d(0.0, -1.0, 0.0)})
    for (const Eigen::Vector3d& place :
         {Eigen::Vector3d(1, -1, 0.5), Eigen::Vector3d(-3, 0.2, -1)}) {
      const PictureCamera camera =
          frame_mesh(sphere(1.0), viewing_direction(place.normalized(), up),
                     {.width = 51, .height = 51, .up = up});
      EXPECT_LT((camera.picture_axes().row(2).transpose() - place.normalized()).norm(), 1e-6);
      EXPECT_NEAR(camera.picture_axes().row(0).dot(up), 0.0, 1e-9);  // Not tilted,
      EXPECT_GT(camera.picture_axes().row(1).dot(up), 0.0);          // nor upside down.
    }
}

TEST(FrameMesh, AnOrthographicPictureHasParallelRays) {
  const PictureCamera camera = frame_mesh(sphere(1.0), {}, {.field_of_view_deg = 0.0});
  EXPECT_LT((camera.ray(0, 0).direction - camera.ray(900, 700).direction).norm(), 1e-12);
  EXPECT_FALSE(camera.rays_start_at_sensor());
}

TEST(FrameSeries, KeepsTheDistanceAndShowsEverything) {
  const TriangleMesh mesh = cloud();
  const FramingOptions options{.width = 200, .height = 150};
  const auto cameras = frame_series(mesh, turntable_directions({10, 25, 0}, 7), options);
  ASSERT_EQ(cameras.size(), 7u);
  Eigen::AlignedBox3d bounds;
  for (const auto& vertex : mesh.vertices) bounds.extend(vertex);
  const double distance = (cameras[0].world_from_camera.translation() - bounds.center()).norm();
  double least = 1.0;
  for (const PictureCamera& camera : cameras) {
    EXPECT_NEAR((camera.world_from_camera.translation() - bounds.center()).norm(), distance,
                1e-9 * distance);
    const Eigen::AlignedBox2d box = picture_box(mesh, camera);
    least = std::min({least, (box.min().x() + 0.5) / 200, (box.min().y() + 0.5) / 150,
                      1.0 - (box.max().x() + 0.5) / 200, 1.0 - (box.max().y() + 0.5) / 150});
  }
  EXPECT_NEAR(least, options.margin, 1e-9);
}

TEST(FrameView, CutsTheGridToItsSamples) {
  RangeView view;
  view.camera = Camera::pinhole(640, 480, {500, 500, 319.5, 239.5});
  view.range = Grid<double>(640, 480, kNoSample);
  view.world_from_view.translation() << 1, 2, 3;
  for (int v = 102; v <= 198; ++v)
    for (int u = 302; u <= 348; ++u) view.range(u, v) = 7.0;
  const PictureCamera camera = frame_view(view, 400, 200);
  EXPECT_EQ(camera.height, 200);
  EXPECT_EQ(camera.width, 100);  // 50 x 100 pixels of the view, enlarged twice
  EXPECT_NEAR(camera.step.x(), 0.5, 1e-12);
  // The middle of the picture is the middle of the samples, on the view's own ray.
  const Ray middle = camera.ray(49.5, 99.5), own = view.camera.ray(325, 150);
  EXPECT_LT((middle.direction - own.direction).norm(), 1e-12);
  EXPECT_LT((middle.origin - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
}

TEST(FrameView, ShowsNoMirrorImage) {
  // Rows grow upwards, as in scans whose first row is the lowest.
  RangeView view;
  view.camera = Camera::orthographic(40, 30, {0, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 0, 1});
  view.range = Grid<double>(40, 30, 7.0);
  const PictureCamera camera = frame_view(view, 80, 60);
  EXPECT_NEAR(camera.picture_axes().determinant(), 1.0, 1e-9);
  EXPECT_GT(camera.ray(0, 59).origin.y(), camera.ray(0, 0).origin.y());  // y is down
  EXPECT_NEAR(camera.ray(0, 29.5).origin.y(), -14.5, 1e-9);
}

TEST(PictureCamera, AxesOfMirroredCamerasAreThoseOfThePicture) {
  // z is behind the sensor, v grows upwards: right, up and towards the viewer stay x, y and z.
  PictureCamera camera;
  camera.camera = Camera::pinhole_gl(21, 21, {30, -30, 10, 10});
  camera.width = camera.height = 21;
  EXPECT_LT((camera.picture_axes() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
}

}  // namespace
}  // namespace relief::rendering
