// Clouds of lidars: bare floats, and from where they were seen.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include <Eigen/Core>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "relief/io/project_io.h"
#include "scan/io/clouds/cloud_grid.h"
#include "scan/io/clouds/files/velodyne_bin.h"
#include "scan/io/files/binary_writer.h"
#include "scan/io/grids/cameras/camera_fit.h"
#include "scan/io/project/loading/settled_views.h"
#include "scan/io/project/loading/unorganized_grid.h"
#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using testing::kDegree;
using testing::TemporaryFolder;

// How far a yard reaches from a lidar 1.8 above its floor: walls, and a few round pillars.
double range_of_yard(const Eigen::Vector3d& direction) {
  double range = direction.z() < 0.0 ? -1.8 / direction.z() : 1e9;
  for (const double wall : {18.0, -14.0}) {
    if (wall * direction.x() > 0.0) range = std::min(range, wall / direction.x());
    if (wall * direction.y() > 0.0) range = std::min(range, wall / direction.y());
  }
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector2d at((4.0 + 0.7 * k) * std::cos(1.3 * k),
                             (4.0 + 0.7 * k) * std::sin(1.3 * k));
    const double a = direction.head<2>().squaredNorm(), b = at.dot(direction.head<2>());
    const double discriminant = b * b - a * (at.squaredNorm() - 0.3);
    if (discriminant > 0.0 && b > 0.0) range = std::min(range, (b - std::sqrt(discriminant)) / a);
  }
  return range;
}

Eigen::Vector3d direction_at(double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * kDegree, elevation = elevation_deg * kDegree;
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

PointCloudFile yard(double half_field_deg) {
  PointCloudFile cloud;
  std::mt19937 generator(5);
  std::normal_distribution<double> noise(0.0, 0.01);
  for (double elevation = -22.0; elevation < 6.0; elevation += 0.8)
    for (double azimuth = -half_field_deg; azimuth < half_field_deg; azimuth += 0.4) {
      const Eigen::Vector3d direction = direction_at(azimuth, elevation);
      cloud.points.push_back((range_of_yard(direction) + noise(generator)) * direction);
    }
  std::shuffle(cloud.points.begin(), cloud.points.end(), generator);
  return cloud;
}

TEST(LidarClouds, OfAWideSectorAreSeenFromTheOrigin) {
  const auto grid = value_of(grid_from_cloud(yard(60.0)));
  EXPECT_EQ(grid.assumed_viewpoint, AssumedViewpoint::kOrigin);
  EXPECT_TRUE(grid.camera->ray(3, 3).origin.isZero());
  EXPECT_THAT(grid.notes, Contains(HasSubstr("the origin of the frame")));
}

TEST(LidarClouds, OfOneSetAreSeenFromTheSamePlace) {
  using enum AssumedViewpoint;
  const auto others = [](const std::vector<AssumedViewpoint>& sides) {
    return views_to_see_from_origin(sides).size();
  };
  EXPECT_EQ(others({kOrigin, kFarOff, kOrigin}), 1u);
  EXPECT_EQ(others({kOrigin, kFarOff}), 0u);
  EXPECT_EQ(others({kOrigin, kFarOff, kFarOff}), 0u);
  EXPECT_EQ(others({kNone, kFarOff}), 0u);
}

void write_text(const PointCloudFile& cloud, const std::filesystem::path& path, bool with_normals) {
  std::ofstream file(path);
  file.precision(9);
  for (const Eigen::Vector3d& point : cloud.points) {
    file << point.transpose();
    // As programs leave them that turn them to a place which is not the sensor.
    if (with_normals)
      file << ' ' << (point.x() > 0.0 ? 1.0 : -1.0) * point.normalized().transpose();
    file << '\n';
  }
}

// Normals that face away on one side hide from the points of one cloud that it was seen from the
// origin.
TEST(LidarClouds, WrittenPosesTellFromWhereTheyWereSeen) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "scans");
  for (const char* name : {"a.xyz", "b.xyz", "c.xyz"})
    write_text(yard(180.0), folder / "scans" / name, name[0] == 'b');
  const auto project = value_of(read_project(folder / "scans"));
  EXPECT_EQ(project.seen_from_origin, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_THAT(project.notes,
              Contains(HasSubstr("view b: taken as seen from the origin of the frame, "
                                 "as most clouds of the set are")));
  EXPECT_THAT(project.notes,
              Contains(HasSubstr("the ranges of 2 of 3 views are those of another")));
  EXPECT_THAT(write_project_poses(project, folder / "scans", {}, folder / "aligned.json"), IsOk());
  for (const auto& spec : value_of(read_project_spec(folder / "aligned.json", {})).views) {
    ASSERT_TRUE(spec.grid_options.viewpoint) << spec.name;
    EXPECT_TRUE(spec.grid_options.viewpoint->isZero());
  }
}

std::string floats_of(const PointCloudFile& cloud, std::size_t columns) {
  std::string bytes;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    for (int k = 0; k < 3; ++k) append_little_endian(bytes, static_cast<float>(cloud.points[i][k]));
    append_little_endian(bytes, static_cast<float>(i % 100) / 100.0f);
    if (columns == 5) append_little_endian(bytes, static_cast<float>(i % 32));
  }
  return bytes;
}

TEST(VelodyneBin, AreThoseOfKittiAndNuScenes) {
  const TemporaryFolder folder;
  const PointCloudFile cloud = yard(180.0);
  for (const std::size_t columns : {4, 5}) {
    folder.write("sweep.bin", floats_of(cloud, columns));
    ASSERT_TRUE(is_velodyne_bin(folder / "sweep.bin")) << columns;
    const auto read = value_of(read_point_cloud(folder / "sweep.bin"));
    ASSERT_EQ(read.points.size(), cloud.points.size());
    EXPECT_LT((read.points[7] - cloud.points[7]).norm(), 1e-5);
    EXPECT_EQ(read.colours[50], (Colour{128, 128, 128}));
    EXPECT_EQ(read.viewpoint, Eigen::Vector3d::Zero());
  }
}

TEST(VelodyneBin, AreTakenForNoOtherFile) {
  const TemporaryFolder folder;
  for (const std::string& bytes :
       {std::string(), std::string("640&480&1&") + std::string(4096, '\x3f'),
        std::string(1600, '\0'), std::string(1601, '\0'), floats_of(yard(180.0), 4).substr(1)}) {
    folder.write("other.bin", bytes);
    EXPECT_FALSE(is_velodyne_bin(folder / "other.bin"));
    EXPECT_THAT(read_velodyne_bin(folder / "other.bin"), HasError("no points of a lidar"));
    EXPECT_THAT(read_project(folder / "other.bin"), HasError("COLMAP workspace"));
  }
}

// A lidar with five mirrors: each column of the file has the points of one, row by row of its
// field.
TEST(UnorganizedGrid, OfAFileThatAreNoPictureAreNotTaken) {
  constexpr int kMirrors = 5, kAcross = 60, kRows = 30;
  GridFile grid;
  grid.points = Grid<Eigen::Vector3d>(kMirrors, kAcross * kRows);
  for (int c = 0; c < kMirrors; ++c)
    for (int k = 0; k < kAcross * kRows; ++k) {
      const Eigen::Vector3d direction = direction_at(
          24.0 * (c - 2) + 24.0 * (k % kAcross) / kAcross - 12.0, 0.8 * (k / kAcross) - 20.0);
      grid.points(c, k) = range_of_yard(direction) * direction;
    }
  const auto fitted = [](const GridFile& file) {
    return camera_through_points(file.points, fit_camera(file).model);
  };
  EXPECT_TRUE(is_unorganized(grid, fitted(grid)));
  const auto found = regrid_points(grid, Eigen::Vector3d::Zero());
  ASSERT_TRUE(found);
  EXPECT_GT(found->points.width(), kMirrors * kAcross / 2);
  EXPECT_THAT(found->notes.front(), HasSubstr("no picture"));

  GridFile picture;
  picture.points = Grid<Eigen::Vector3d>(80, 60);
  for (int v = 0; v < 60; ++v)
    for (int u = 0; u < 80; ++u) {
      const Eigen::Vector3d direction = direction_at(0.5 * u - 20.0, 10.0 - 0.5 * v);
      picture.points(u, v) = range_of_yard(direction) * direction;
    }
  EXPECT_FALSE(is_unorganized(picture, fitted(picture)));
}

}  // namespace
}  // namespace relief
