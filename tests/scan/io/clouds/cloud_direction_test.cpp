#include "scan/io/clouds/cloud_direction.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

// A floor 1 below the sensor, from 0.7 to 6 before it along x, on rays half a degree apart, as a
// sensor sees it that turns.
std::string floor_before_sensor() {
  std::string text;
  for (int row = 0; row < 90; ++row)
    for (int column = -180; column <= 180; ++column) {
      const double elevation = (10.0 + 0.5 * row) * std::numbers::pi / 180.0;
      const double azimuth = 0.5 * column * std::numbers::pi / 180.0,
                   distance = 1.0 / std::tan(elevation);
      const double height = 0.002 * std::sin(37.0 * row + 53.0 * column);
      text += std::to_string(distance * std::cos(azimuth)) + " " +
              std::to_string(distance * std::sin(azimuth)) + " " + std::to_string(-1.0 + height) +
              "\n";
    }
  return text;
}

TEST(CloudDirection, MissingSamplesAtTheOriginTellThatTheSensorIsThere) {
  const testing::TemporaryFolder folder;
  const std::string missing = "0 0 0\n0 0 0\n";
  folder.write("floor.xyz", floor_before_sensor());
  folder.write("floor_and_missing.xyz", missing + floor_before_sensor());
  const CloudDirection floor = find_direction(value_of(read_point_cloud(folder / "floor.xyz")));
  EXPECT_EQ(floor.rays.kind, CloudRays::Kind::kParallel);
  EXPECT_FALSE(floor.side_known);
  const CloudDirection with_missing =
      find_direction(value_of(read_point_cloud(folder / "floor_and_missing.xyz")));
  EXPECT_NE(with_missing.rays.kind, CloudRays::Kind::kParallel);
  EXPECT_EQ(with_missing.rays.origin, Eigen::Vector3d::Zero());
  EXPECT_TRUE(with_missing.side_known);
}

}  // namespace
}  // namespace relief
