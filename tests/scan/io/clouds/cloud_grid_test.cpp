#include "scan/io/clouds/cloud_grid.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/io/mesh_io.h"
#include "relief/scan/discontinuities.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/io/clouds/cloud_direction.h"
#include "scan/io/clouds/cloud_lattice.h"
#include "scan/io/clouds/nearest_points.h"
#include "scan/io/grids/grid_view.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_data.h"

namespace relief {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::TemporaryFolder;

std::size_t count_points(const GridFile& grid) {
  return static_cast<std::size_t>(std::count_if(grid.points.begin(), grid.points.end(),
                                                [](const auto& p) { return p.allFinite(); }));
}

// Of the places that have a point within two places on all four sides, those that have one.
double interior_fill(const Grid<Eigen::Vector3d>& points) {
  const auto has = [&](int u, int v) { return points.contains(u, v) && points(u, v).allFinite(); };
  const auto near = [&](int u, int v, int du, int dv) {
    return has(u + du, v + dv) || has(u + 2 * du, v + 2 * dv);
  };
  std::size_t filled = 0, empty = 0;
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (has(u, v))
        ++filled;
      else if (near(u, v, 1, 0) && near(u, v, -1, 0) && near(u, v, 0, 1) && near(u, v, 0, -1))
        ++empty;
    }
  }
  return static_cast<double>(filled) / static_cast<double>(filled + empty);
}

double connected_fraction(const GridFile& grid) {
  const auto view = value_of(view_from_grid(grid, grid.camera));
  const GridEdges edges = connect_samples(view);
  std::size_t pairs = 0, connected = 0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v) || !view.has_sample(u + 1, v)) continue;
      ++pairs;
      connected += edges.right(u, v);
    }
  }
  return static_cast<double>(connected) / static_cast<double>(pairs);
}

Eigen::Vector3d middle_direction(const GridFile& grid) {
  return grid.camera->ray(grid.points.width() / 2, grid.points.height() / 2).direction.normalized();
}

using PointSet = std::set<std::array<double, 3>>;

// Every point of the grid is one of the cloud to the last bit, and none is there twice.
void expect_points_of(const PointCloudFile& cloud, const GridFile& grid) {
  PointSet given, found;
  for (const auto& p : cloud.points) given.insert({p.x(), p.y(), p.z()});
  for (const auto& p : grid.points) {
    if (!p.allFinite()) continue;
    ASSERT_TRUE(given.contains({p.x(), p.y(), p.z()}));
    ASSERT_TRUE(found.insert({p.x(), p.y(), p.z()}).second);
  }
}

// The rendered view as points in no order, in the world or in the view's own frame.
PointCloudFile cloud_of(const RangeView& view, bool in_world) {
  PointCloudFile cloud;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const Eigen::Vector3d point = view.point(u, v);
      cloud.points.push_back(in_world ? view.world_from_view * point : point);
    }
  }
  std::mt19937 random(5);
  std::shuffle(cloud.points.begin(), cloud.points.end(), random);
  return cloud;
}

const Eigen::Vector3d kEye(3, -4, 2);

RangeView sphere_view() {
  return testing::render(testing::sphere({0, 0, 0}, 1.0),
                         Camera::pinhole(160, 120, {300, 300, 79.5, 59.5}),
                         testing::look_at(kEye, {0, 0, 0}));
}

TEST(NearestPoints, FindsWhatAllDistancesSay) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 500; ++i) points.emplace_back(uniform(random), uniform(random), 0.1 * i);
  points.push_back(points.front());
  const NearestPoints<3> tree(points);
  for (const auto& query : points) {
    std::vector<double> distances;
    for (const auto& point : points)
      if (point != query) distances.push_back((point - query).squaredNorm());
    std::sort(distances.begin(), distances.end());
    const auto found = tree.find(query, 7);
    ASSERT_EQ(found.size(), 7u);
    for (std::size_t k = 0; k < 7; ++k) ASSERT_EQ(found[k].squared_distance, distances[k]);
  }
}

TEST(CloudLattice, FindsTheStepsAndTheTurnOfRows) {
  std::vector<Eigen::Vector2d> at;
  const double angle = 0.3;
  const Eigen::Vector2d u(std::cos(angle), std::sin(angle)), v(-u.y(), u.x());
  for (int j = 0; j < 40; ++j)
    for (int i = 0; i < 60; ++i) at.push_back(0.5 * i * u + 1.25 * j * v);
  const auto lattice = value_of(fit_lattice(at, true));
  EXPECT_LT((lattice.step_u - 0.5 * u).norm(), 1e-9);
  EXPECT_LT((lattice.step_v - 1.25 * v).norm(), 1e-9);
  EXPECT_NEAR(lattice.width, 60, 2);
  EXPECT_NEAR(lattice.height, 40, 2);
}

TEST(CloudGrid, KeepsThePointsOfAPerspectiveViewFromItsViewpoint) {
  const PointCloudFile cloud = cloud_of(sphere_view(), true);
  CloudGridOptions options;
  options.viewpoint = kEye;
  const auto grid = value_of(grid_from_cloud(cloud, options));
  expect_points_of(cloud, grid);
  EXPECT_GT(count_points(grid), cloud.points.size() * 98 / 100);
  EXPECT_GT(interior_fill(grid.points), 0.97);
  EXPECT_GT(connected_fraction(grid), 0.97);
  // Rays come from the viewpoint, and the projection agrees with them.
  const Ray ray = grid.camera->ray(20, 30);
  EXPECT_LT((ray.origin - kEye).norm(), 1e-12);
  const auto pixel = grid.camera->project(ray.at(3.0));
  ASSERT_TRUE(pixel.has_value());
  EXPECT_LT((*pixel - Eigen::Vector2d(20, 30)).norm(), 1e-9);
}

TEST(CloudGrid, PointsAreWithinOnePlaceOfTheirRays) {
  const PointCloudFile cloud = cloud_of(sphere_view(), true);
  for (const bool given : {true, false}) {
    CloudGridOptions options;
    if (given) options.viewpoint = kEye;
    const auto grid = value_of(grid_from_cloud(cloud, options));
    for (int v = 0; v < grid.points.height(); ++v) {
      for (int u = 0; u < grid.points.width(); ++u) {
        if (!grid.points(u, v).allFinite()) continue;
        const auto pixel = grid.camera->project(grid.points(u, v));
        ASSERT_TRUE(pixel.has_value());
        ASSERT_LE((*pixel - Eigen::Vector2d(u, v)).cwiseAbs().maxCoeff(), 1.0 + 1e-6);
      }
    }
  }
}

TEST(CloudGrid, TakesTheOriginOfADepthCamera) {
  const PointCloudFile cloud = cloud_of(sphere_view(), false);
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_TRUE(grid.camera->ray(3, 3).origin.isZero());
  EXPECT_THAT(grid.notes, Contains(HasSubstr("the origin of the frame")));
  EXPECT_GT(count_points(grid), cloud.points.size() * 98 / 100);
}

TEST(CloudGrid, TakesTheOriginOfADepthCameraThatSeesFarStrays) {
  PointCloudFile cloud = cloud_of(sphere_view(), false);
  // One in 200, along rays of the camera, up to a hundred times as far.
  const std::size_t measured = cloud.points.size();
  for (std::size_t i = 0; i < measured / 200; ++i)
    cloud.points.push_back(cloud.points[200 * i] *
                           (2.0 + 98.0 * static_cast<double>(i % 50) / 49.0));
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_TRUE(grid.camera->ray(3, 3).origin.isZero());
  EXPECT_THAT(grid.notes, Contains(HasSubstr("the origin of the frame")));
  EXPECT_GT(count_points(grid), measured * 98 / 100);
}

// The picture is that of the camera, not one about what it happens to see.
TEST(CloudGrid, TakesTheAxisOfADepthCamera) {
  const double step = 1.0 / 128.0;
  PointCloudFile cloud;
  for (int v = -20; v < 60; ++v)
    for (int u = 0; u < 120; ++u) {
      const double depth = 0.001 * std::round(1000.0 * (2.0 + std::sin(0.05 * u) * 0.3));
      cloud.points.emplace_back(u * step * depth, v * step * depth, -depth);
    }
  const std::size_t measured = cloud.points.size();
  for (int k = 0; k < 5; ++k) cloud.points.emplace_back(1.4, 0.1 * k, -1.0);  // Strays, 54 degrees.
  CloudGridOptions options;
  options.viewpoint = Eigen::Vector3d::Zero();
  const auto grid = value_of(grid_from_cloud(cloud, options));
  EXPECT_GE(count_points(grid), measured);
  const auto view = value_of(view_from_grid(grid, grid.camera));
  for (int v = 0; v < view.height(); v += 7)
    for (int u = 0; u < view.width(); u += 7)
      if (view.has_sample(u, v)) {
        EXPECT_NEAR(view.range(u, v), -view.point(u, v).z(), 1e-6);
      }
}

// The same in the axes of a robot: x forward, z upwards.
TEST(CloudGrid, TakesTheAxisOfADepthCameraOfARobot) {
  PointCloudFile cloud;
  for (int v = -20; v < 60; ++v)
    for (int u = 0; u < 120; ++u) {
      const double depth = 0.001 * std::round(1000.0 * (2.0 + std::sin(0.05 * u) * 0.3));
      cloud.points.emplace_back(depth, -u / 128.0 * depth, -v / 128.0 * depth);
    }
  const auto grid = value_of(grid_from_cloud(cloud, {}));
  EXPECT_EQ(count_points(grid), cloud.points.size());
  const auto view = value_of(view_from_grid(grid, grid.camera));
  EXPECT_NEAR(view.width() * view.height(), 120 * 80, 0.05 * 120 * 80);
  for (int v = 0; v < view.height(); v += 7)
    for (int u = 0; u < view.width(); u += 7)
      if (view.has_sample(u, v)) {
        EXPECT_NEAR(view.range(u, v), view.point(u, v).x(), 1e-6);
      }
}

// A pinhole picture of 65 degrees to each side, on a surface with a step. `robot`: x is forward.
PointCloudFile wide_cloud(bool robot, bool own_picture) {
  PointCloudFile cloud;
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  for (int v = -40; v <= 40; ++v)
    for (int u = -60; u <= 60; ++u) {
      const double depth = (u < 10 ? 2.0 : 2.4) + std::sin(0.05 * v) * 0.1;
      const double x = (u + (own_picture ? 0.0 : shift(generator))) / 28.0 * depth,
                   y = (v + (own_picture ? 0.0 : shift(generator))) / 28.0 * depth;
      if (robot)
        cloud.points.emplace_back(depth, -x, -y);
      else
        cloud.points.emplace_back(x, y, depth);
    }
  return cloud;
}

TEST(CloudGrid, TakesThePictureOfAWideCamera) {
  for (const bool robot : {false, true}) {
    const PointCloudFile cloud = wide_cloud(robot, true);
    const auto grid = value_of(grid_from_cloud(cloud, {}));
    EXPECT_EQ(count_points(grid), cloud.points.size()) << robot;
    const auto view = value_of(view_from_grid(grid, grid.camera));
    EXPECT_NEAR(view.width() * view.height(), 121 * 81, 0.05 * 121 * 81) << robot;
  }
}

// As lenses give them that are no pinhole: the middle of the view is no pole.
TEST(CloudGrid, SeesAWideViewAlongZByEvenAngles) {
  const PointCloudFile cloud = wide_cloud(false, false);
  const CloudRays rays = rays_from(Eigen::Vector3d::Zero(), cloud.points);
  EXPECT_EQ(rays.kind, CloudRays::Kind::kSpherical);
  EXPECT_FALSE(surround(cloud.points, rays));
  EXPECT_NEAR(rays.project(Eigen::Vector3d(0, 0, 2)).head<2>().norm(), 0.0, 1e-12);
  const auto grid = value_of(grid_from_cloud(cloud, {}));
  EXPECT_GT(count_points(grid), cloud.points.size() * 9 / 10);
  for (const Eigen::Vector3d& point : grid.points)
    if (point.allFinite()) {
      EXPECT_GT(point.z(), 1.8);
    }
}

TEST(CloudGrid, FindsTheSideOfASolidObject) {
  const PointCloudFile cloud = cloud_of(sphere_view(), true);
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_EQ(grid.camera->model(), Camera::Model::kOrthographic);
  EXPECT_GT(middle_direction(grid).dot(-kEye.normalized()), std::cos(0.2));
  EXPECT_THAT(grid.notes, Contains(HasSubstr("a guess: the side from which outlines turn away")));
  expect_points_of(cloud, grid);
  EXPECT_GT(count_points(grid), cloud.points.size() * 9 / 10);
}

TEST(CloudGrid, NormalsTellTheSide) {
  // The inside of a bowl, whose outlines turn towards the sensor.
  PointCloudFile cloud = cloud_of(sphere_view(), true);
  for (const auto& point : cloud.points) cloud.normals.push_back((-point).cast<float>());
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_GT(middle_direction(grid).dot(kEye.normalized()), 0.9);
  EXPECT_THAT(grid.notes, Contains(HasSubstr("the side that the normals face")));
  EXPECT_THAT(grid.notes, Contains(HasSubstr("the outlines turn towards that side")));
  for (std::size_t i = 0; i < grid.points.size(); ++i) {
    if (!grid.points[i].allFinite()) continue;
    ASSERT_EQ(grid.normals[i], Eigen::Vector3f((-grid.points[i]).cast<float>()));
  }
}

TEST(CloudGrid, FacesTellTheSideButAreNoNormals) {
  PointCloudFile cloud = cloud_of(sphere_view(), true);
  for (const auto& point : cloud.points) cloud.facing.push_back((-point).cast<float>());
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_GT(middle_direction(grid).dot(kEye.normalized()), 0.9);
  EXPECT_TRUE(grid.normals.empty());
}

TEST(CloudGrid, IsTheSameWhereTheCloudIsMoved) {
  PointCloudFile cloud = cloud_of(sphere_view(), true);
  const auto grid = value_of(grid_from_cloud(cloud));
  const Eigen::Vector3d shift(1000, 2000, -500);
  for (auto& point : cloud.points) point = 4.0 * point + shift;
  const auto moved = value_of(grid_from_cloud(cloud));
  EXPECT_LT((middle_direction(moved) - middle_direction(grid)).norm(), 0.05);
  const auto kept = static_cast<double>(count_points(grid));
  EXPECT_NEAR(static_cast<double>(count_points(moved)), kept, 0.01 * kept);
}

TEST(CloudGrid, UsesADirectionThatIsGiven) {
  PointCloudFile cloud;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 50; ++x) cloud.points.emplace_back(0.25 * x, 0.5 * y, std::sin(0.1 * x));
  cloud.colours.assign(cloud.points.size(), Colour{1, 2, 3});
  CloudGridOptions options;
  options.direction = Eigen::Vector3d(0, 0, -2);
  const auto grid = value_of(grid_from_cloud(cloud, options));
  EXPECT_EQ(count_points(grid), cloud.points.size());
  EXPECT_EQ(interior_fill(grid.points), 1.0);
  EXPECT_TRUE(grid.notes.empty());
  const Ray ray = grid.camera->ray(0, 0);
  EXPECT_EQ(ray.direction, Eigen::Vector3d(0, 0, -1));
  EXPECT_NEAR((grid.camera->ray(1, 0).origin - ray.origin).norm(), 0.25, 1e-9);
  EXPECT_NEAR((grid.camera->ray(0, 1).origin - ray.origin).norm(), 0.5, 1e-9);
  EXPECT_EQ(grid.colours.size(), grid.points.size());
}

TEST(CloudGrid, LeavesOutWhatIsHidden) {
  PointCloudFile cloud;
  for (const double z : {0.0, 5.0})
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 30; ++x) cloud.points.emplace_back(0.1 * x, 0.1 * y, z);
  CloudGridOptions options;
  options.direction = Eigen::Vector3d(0, 0, 1);
  const auto grid = value_of(grid_from_cloud(cloud, options));
  EXPECT_EQ(count_points(grid), 900u);
  for (const auto& point : grid.points)
    if (point.allFinite()) {
      EXPECT_EQ(point.z(), 0.0);
    }
  EXPECT_THAT(grid.notes, Contains("900 of 1800 points lie behind others and are left out"));
  EXPECT_THAT(grid.notes, Contains(HasSubstr("give the viewpoint")));
}

TEST(CloudGrid, CountsPointsThatShareARay) {
  PointCloudFile cloud;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 30; ++x) cloud.points.emplace_back(0.1 * x, 0.1 * y, 0.0);
  cloud.points.emplace_back(1.5 + 1e-4, 1.5, 0.0);
  CloudGridOptions options;
  options.direction = Eigen::Vector3d(0, 0, 1);
  const auto grid = value_of(grid_from_cloud(cloud, options));
  EXPECT_EQ(count_points(grid), 900u);
  EXPECT_THAT(grid.notes, Contains("1 of 901 points share a ray with another and are left out"));
}

constexpr double kRoomStep = std::numbers::pi / 180.0;

// Walls, floor and ceiling of a box around the origin, by angles that are even but for `jitter`
// [steps].
PointCloudFile room_around_origin(double jitter) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> off(-jitter, jitter);
  PointCloudFile cloud;
  for (int row = -60; row <= 60; ++row) {
    for (int column = 0; column < 360; ++column) {
      const double azimuth = (column + off(random)) * kRoomStep;
      const double elevation = (row + off(random)) * kRoomStep;
      const Eigen::Vector3d d(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      cloud.points.push_back(d * std::min({3.0 / std::abs(d.x()), 2.0 / std::abs(d.y()),
                                           d.z() == 0.0 ? 1e9 : 1.5 / std::abs(d.z())}));
    }
  }
  return cloud;
}

TEST(CloudGrid, SeesARoomAllRound) {
  const PointCloudFile cloud = room_around_origin(0.0);
  CloudGridOptions options;
  options.viewpoint = Eigen::Vector3d::Zero();
  const auto grid = value_of(grid_from_cloud(cloud, options));
  EXPECT_GT(count_points(grid), cloud.points.size() * 97 / 100);
  EXPECT_NEAR(grid.points.width(), 360, 4);
  EXPECT_NEAR(grid.points.height(), 121, 4);
  for (int v = 0; v < grid.points.height(); v += 7) {
    for (int u = 0; u < grid.points.width(); u += 7) {
      if (!grid.points(u, v).allFinite()) continue;
      const Eigen::Vector3d direction = grid.points(u, v).normalized();
      ASSERT_GT(grid.camera->ray(u, v).direction.dot(direction), std::cos(2.0 * kRoomStep));
    }
  }
}

// Points that lie beside the middles of their cells, as those of thinned scans do, keep a
// projection all the same: without one, views cannot be merged.
TEST(CloudGrid, ProjectsIntoARoomOfIrregularPoints) {
  CloudGridOptions options;
  options.viewpoint = Eigen::Vector3d::Zero();
  const auto grid = value_of(grid_from_cloud(room_around_origin(0.4), options));
  const auto view = value_of(view_from_grid(grid, grid.camera));
  ASSERT_TRUE(view.camera.can_project());
  for (int v = 2; v < view.height(); v += 9) {
    for (int u = 2; u < view.width(); u += 9) {
      if (!view.has_sample(u, v)) continue;
      const auto pixel = view.camera.project(view.point(u, v));
      ASSERT_TRUE(pixel);
      EXPECT_LT((*pixel - Eigen::Vector2d(u, v)).lpNorm<Eigen::Infinity>(), 1.6);
    }
  }
}

TEST(CloudGrid, TakesTheOriginOfAScannerInItsSurroundings) {
  const auto grid = value_of(grid_from_cloud(room_around_origin(0.4)));
  EXPECT_TRUE(grid.camera->spherical_projection());
  EXPECT_THAT(grid.notes, Contains(HasSubstr("all around which the points lie")));
}

// As a fit of planes to the neighbours of each point leaves them.
TEST(CloudGrid, TurnsNormalsToTheSensorWhereNeighboursHaveOppositeOnes) {
  PointCloudFile cloud = room_around_origin(0.4);
  std::mt19937 random(3);
  for (const auto& point : cloud.points) {
    const Eigen::Vector3d part = point.cwiseAbs().cwiseQuotient(Eigen::Vector3d(3.0, 2.0, 1.5));
    Eigen::Index wall = 0;
    part.maxCoeff(&wall);
    const float sign = random() % 3 == 0 ? -1.0f : 1.0f;
    cloud.normals.push_back(sign * Eigen::Vector3f::Unit(wall));
  }
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_TRUE(grid.camera->spherical_projection());
  EXPECT_THAT(grid.notes, Contains(HasSubstr("neighbours have opposite normals")));
  for (int v = 0; v < grid.points.height(); ++v)
    for (int u = 0; u < grid.points.width(); ++u)
      if (const Eigen::Vector3d& point = grid.points(u, v); point.allFinite()) {
        ASSERT_LE(grid.normals(u, v).cast<double>().dot(point), 0.0);
      }
}

// A lidar without rows of rays: they are at random, half of them close together to either side.
// Most points of the others lie alone, and few hide another one in cells of the typical spacing.
TEST(CloudGrid, TakesTheOriginOfALidarWithoutRows) {
  std::mt19937 random(7);
  std::normal_distribution<double> gauss;
  PointCloudFile cloud;
  for (int i = 0; i < 20000; ++i) {
    Eigen::Vector3d d(gauss(random), gauss(random), 0.4 * gauss(random));
    if (i % 2 == 0) d = 0.15 * d.cwiseProduct(Eigen::Vector3d(1.0, 1.0, 2.5));
    if (i % 2 == 0) d.x() += i % 4 == 0 ? 1.0 : -1.0;
    d.normalize();
    cloud.points.push_back(d * std::min({8.0 / std::abs(d.x()), 5.0 / std::abs(d.y()),
                                         (d.z() < 0.0 ? 1.2 : 2.0) / std::abs(d.z())}));
  }
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_TRUE(grid.camera->spherical_projection());
  EXPECT_THAT(grid.notes, Contains(HasSubstr("all around which the points lie")));
}

// A yard with a hedge before its walls, thinned to one point in each cube of 10 cm. The hedge has
// holes of 3 degrees: in wider cells, what lies behind them is seen beside the hedge.
PointCloudFile yard_behind_a_hedge(const Eigen::Vector3d& sensor) {
  std::mt19937 random(11);
  const auto number = [&] { return static_cast<double>(random()) / 4294967296.0; };
  std::set<std::array<int, 3>> taken;
  PointCloudFile cloud;
  for (int i = 0; i < 300000; ++i) {
    const double sine = -0.7 + 1.3 * number(), azimuth = 2.0 * EIGEN_PI * number();
    const double cosine = std::sqrt(1.0 - sine * sine);
    const Eigen::Vector3d ray(std::cos(azimuth) * cosine, std::sin(azimuth) * cosine, sine);
    double range = std::min({(ray.x() > 0.0 ? 14.0 : 11.0) / std::abs(ray.x()),
                             (ray.y() > 0.0 ? 9.0 : 12.0) / std::abs(ray.y()),
                             ray.z() < 0.0 ? -1.7 / ray.z() : 100.0});
    const double hedge = (4.0 + 0.6 * number()) / ray.head<2>().norm();
    const auto block = [](double angle) { return std::floor(angle / (3.0 * EIGEN_PI / 180.0)); };
    const bool hole = std::sin(12.9 * block(azimuth) + 78.2 * block(std::asin(sine))) > 0.0;
    if (!hole && hedge < range && hedge * ray.z() < 2.0) range = hedge;
    const Eigen::Vector3d point = range * ray;
    if (point.z() > 6.0) continue;
    const Eigen::Vector3i cube = (point / 0.1).array().floor().cast<int>();
    if (taken.insert({cube.x(), cube.y(), cube.z()}).second) cloud.points.push_back(point + sensor);
  }
  return cloud;
}

TEST(CloudGrid, TakesTheOriginWhereSurfacesHaveHoles) {
  const auto grid = value_of(grid_from_cloud(yard_behind_a_hedge(Eigen::Vector3d::Zero())));
  EXPECT_EQ(grid.assumed_viewpoint, AssumedViewpoint::kOrigin);
  EXPECT_THAT(grid.notes, Contains(HasSubstr("few points lie far behind others")));
  // The sensor stood beside the origin, from which the hedge hides other things.
  const auto other = value_of(grid_from_cloud(yard_behind_a_hedge({5.0, -4.0, 0.0})));
  EXPECT_EQ(other.assumed_viewpoint, AssumedViewpoint::kFarOff);
}

// A street with trunks between walls, thinned to one point in each cube of 20 cm: from above hardly
// anything is hidden. Elevations are those of a lidar of 32 lasers, or any.
PointCloudFile thinned_street(bool rings) {
  std::mt19937 random(5);
  const auto number = [&] { return static_cast<double>(random()) / 4294967296.0; };
  std::set<std::array<int, 3>> taken;
  PointCloudFile cloud;
  for (int i = 0; i < 120000; ++i) {
    const double step = rings ? std::floor(32.0 * number()) : 32.0 * number();
    const double elevation = (-30.0 + 1.3 * step) * EIGEN_PI / 180.0;
    const double azimuth = 2.0 * EIGEN_PI * number();
    const Eigen::Vector3d ray(std::cos(azimuth) * std::cos(elevation),
                              std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
    double range = 50.0;
    if (ray.z() < 0.0) range = std::min(range, -1.8 / ray.z());
    range = std::min(range, (ray.y() > 0.0 ? 6.0 : 9.0) / std::abs(ray.y()));
    for (int k = -4; k <= 4; ++k) {  // Trunks of 40 cm.
      const Eigen::Vector2d trunk(3.0 * k + 1.0, k % 2 == 0 ? 3.0 : -4.0);
      const Eigen::Vector2d along = ray.head<2>().normalized();
      const double off = along.x() * trunk.y() - along.y() * trunk.x();
      const double distance = along.dot(trunk) - std::sqrt(std::max(0.0, 0.04 - off * off));
      if (std::abs(off) < 0.2 && distance > 0.0)
        range = std::min(range, distance / ray.head<2>().norm());
    }
    if (range >= 50.0) continue;
    const Eigen::Vector3d point = (range + 0.04 * (number() - 0.5)) * ray;
    const Eigen::Vector3i cube = (point / 0.2).array().floor().cast<int>();
    if (taken.insert({cube.x(), cube.y(), cube.z()}).second) cloud.points.push_back(point);
  }
  return cloud;
}

TEST(CloudGrid, TakesTheOriginWherePointsLieOnTheRingsOfALidar) {
  const auto grid = value_of(grid_from_cloud(thinned_street(true)));
  EXPECT_THAT(grid.notes, Contains(HasSubstr("lie on the rings of a lidar")));
  EXPECT_TRUE(grid.camera->spherical_projection());
  const auto other = value_of(grid_from_cloud(thinned_street(false)));
  EXPECT_THAT(other.notes, Not(Contains(HasSubstr("rings"))));
}

// A cap round the origin, to 80 degrees off the axis, seen from above: nothing is hidden along
// parallel rays.
TEST(CloudGrid, SaysThatPointsLieAroundTheOriginOfAnObject) {
  PointCloudFile cloud;
  for (double x = -0.99; x <= 0.99; x += 0.01)
    for (double y = -0.99; y <= 0.99; y += 0.01)
      if (x * x + y * y < 0.97) cloud.points.emplace_back(x, y, std::sqrt(1.0 - x * x - y * y));
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_EQ(grid.camera->model(), Camera::Model::kOrthographic);
  EXPECT_THAT(grid.notes, Contains(HasSubstr("give the viewpoint 0 0 0")));
}

// Three walls, floor and ceiling at one end of a room: hardly anything is hidden from far off.
PointCloudFile end_of_room() {
  PointCloudFile cloud = room_around_origin(0.05);
  std::erase_if(cloud.points, [](const auto& point) { return point.x() < -0.3; });
  return cloud;
}

TEST(CloudGrid, TakesTheOriginFromWhichEachPointHasARayOfItsOwn) {
  const auto grid = value_of(grid_from_cloud(end_of_room()));
  EXPECT_TRUE(grid.camera->spherical_projection());
  EXPECT_THAT(grid.notes, Contains(HasSubstr("each point has a ray of its own")));
}

// 32 rings a degree and a third apart, each of 1800 points at uneven angles, from a vehicle on a
// square: far points and near spacings.
PointCloudFile rings_of_a_vehicle() {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> off(-0.9, 0.9);
  PointCloudFile cloud;
  for (int ring = 0; ring < 32; ++ring) {
    const double elevation = (1.33 * ring - 30.67 + 0.06 * off(random)) * kRoomStep;
    for (int column = 0; column < 1800; ++column) {
      const double azimuth = 0.2 * (column + off(random)) * kRoomStep;
      const Eigen::Vector3d d(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const double ground = d.z() < 0.0 ? 1.7 / -d.z() : 1e9;
      const double range = std::min({ground, 100.0 / std::abs(d.y()), 300.0 / std::abs(d.x())});
      cloud.points.push_back(range * d);
    }
  }
  return cloud;
}

TEST(CloudGrid, TakesTheOriginOfAScannerOfFewRings) {
  const PointCloudFile cloud = rings_of_a_vehicle();
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_TRUE(grid.camera->spherical_projection());
  EXPECT_GT(count_points(grid), cloud.points.size() * 85 / 100);
}

TEST(CloudGrid, DoesNotTakeAnOriginThatNormalsLookAwayFrom) {
  PointCloudFile cloud = end_of_room();
  for (const auto& point : cloud.points) cloud.normals.push_back(point.normalized().cast<float>());
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_EQ(grid.camera->model(), Camera::Model::kOrthographic);
}

TEST(CloudGrid, DoesNotTakeAnOriginThatIsNotTheSensor) {
  PointCloudFile cloud = end_of_room();
  for (auto& point : cloud.points) point -= Eigen::Vector3d(1.0, -0.5, 0.4);
  EXPECT_THAT(value_of(grid_from_cloud(cloud)).notes,
              Each(Not(HasSubstr("each point has a ray of its own"))));
}

TEST(CloudGrid, IrregularPointsStayConnected) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  PointCloudFile cloud;
  for (int i = 0; i < 20000; ++i) {
    const double x = uniform(random), y = uniform(random);
    cloud.points.emplace_back(x, y, 0.2 * std::cos(2 * x) * std::cos(2 * y));
  }
  const auto grid = value_of(grid_from_cloud(cloud));
  expect_points_of(cloud, grid);
  EXPECT_GT(count_points(grid), cloud.points.size() * 85 / 100);
  EXPECT_GT(connected_fraction(grid), 0.95);
}

TEST(CloudGrid, LeavesPointsFarOffOutside) {
  PointCloudFile cloud = cloud_of(sphere_view(), true);
  cloud.points.emplace_back(1e7, 0, 0);
  cloud.points.emplace_back(0, -1e8, 1e8);
  CloudGridOptions options;
  options.direction = -kEye;
  const auto grid = value_of(grid_from_cloud(cloud, options));
  EXPECT_THAT(grid.notes, Contains(HasSubstr("2 of")));
  EXPECT_LT(grid.points.size(), 64 * cloud.points.size() + 10000);
}

TEST(CloudGrid, RefusesWhatIsNoScan) {
  EXPECT_THAT(grid_from_cloud({}), HasError("the cloud has no points"));
  PointCloudFile line, place;
  for (int i = 0; i < 100; ++i) line.points.emplace_back(i, 2 * i, 3);
  for (int i = 0; i < 100; ++i) place.points.emplace_back(1, 2, 3);
  EXPECT_THAT(grid_from_cloud(line), HasError("on a line"));
  EXPECT_THAT(grid_from_cloud(place), HasError("at one place"));
  line.normals.resize(3);
  EXPECT_THAT(grid_from_cloud(line), HasError("not one normal or colour for each point"));
  PointCloudFile cloud = cloud_of(sphere_view(), true);
  CloudGridOptions options;
  options.direction = Eigen::Vector3d::Zero();
  EXPECT_THAT(grid_from_cloud(cloud, options), HasError("is no direction"));
  options.viewpoint = Eigen::Vector3d::Constant(kNoSample);
  EXPECT_THAT(grid_from_cloud(cloud, options), HasError("viewpoint of the cloud is not finite"));
}

TEST(CloudGrid, ExtremeCoordinatesNeverCrash) {
  std::mt19937_64 random(9);
  for (int k = 0; k < 300; ++k) {
    PointCloudFile cloud;
    for (int i = 0; i < 40; ++i) {
      Eigen::Vector3d point;
      for (double& value : point) {
        const int power = static_cast<int>(random() % 617) - 308;
        value = (random() % 3 ? 1.0 : -1.0) * std::pow(10.0, k % 2 ? power : power % 4) *
                static_cast<double>(random() % 10);
      }
      if (point.allFinite()) cloud.points.push_back(point);
    }
    CloudGridOptions options;
    if (k % 3 == 0) options.viewpoint = cloud.points[0];
    (void)grid_from_cloud(cloud, options);
  }
}

// A range-grid PLY as text of points.
std::string text_of(const GridFile& grid) {
  std::string text;
  char buffer[40];
  for (const auto& point : grid.points) {
    if (!point.allFinite()) continue;
    for (const double value : point) {
      text.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
      text += ' ';
    }
    text += '\n';
  }
  return text;
}

TEST(CloudGrid, RealScansAsTextKeepTheirPoints) {
  RELIEF_REQUIRE_TEST_DATA(path, "dragon");
  const TemporaryFolder folder;
  for (const char* name : {"0", "48", "144", "264", "312"}) {
    const auto scan =
        value_of(read_ply_grid(path / ("dragonStandRight_" + std::string(name) + ".ply")));
    const auto cloud = value_of(read_point_cloud(folder.write("a.xyz", text_of(scan))));
    ASSERT_EQ(cloud.points.size(), count_points(scan));
    const auto grid = value_of(grid_from_cloud(cloud));
    expect_points_of(cloud, grid);
    EXPECT_GT(count_points(grid), cloud.points.size() * 9 / 10) << name;
    EXPECT_GT(interior_fill(grid.points), 0.85) << name;
    EXPECT_GT(connected_fraction(grid), 0.95) << name;
    // The sensor is where z grows.
    EXPECT_LT(middle_direction(grid).z(), -0.8) << name;
  }
}

TEST(CloudGrid, RealRangeMeshesAsViews) {
  RELIEF_REQUIRE_TEST_DATA(path, "bunny/bun000.ply");
  const auto scan = value_of(read_ply_grid(path));
  const auto view = value_of(view_from_grid(scan));
  const TemporaryFolder folder;
  ASSERT_THAT(write_mesh(mesh_from_view(view), folder / "a.stl"), IsOk());
  const auto cloud = value_of(read_point_cloud(folder / "a.stl"));
  const auto grid = value_of(grid_from_cloud(cloud));
  EXPECT_GT(count_points(grid), cloud.points.size() * 9 / 10);
  EXPECT_GT(interior_fill(grid.points), 0.85);
  EXPECT_LT(middle_direction(grid).z(), -0.9);
  EXPECT_THAT(grid.notes, Contains(HasSubstr("the side that the normals face")));
}

}  // namespace
}  // namespace relief
