#include "scan/io/clouds/normal_orientation.h"

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "scan/io/clouds/cloud_direction.h"
#include "scan/io/clouds/nearest_points.h"

namespace relief {

namespace {

constexpr std::size_t kMostPoints = 40000;  // That are looked at; bounds the time.
// Cosine between the lines of two normals of one surface: 30 degrees.
constexpr double kAlike = 0.866;
// Of neighbours along one line, so many are opposite at most where signs mean a side: strays, and
// the two sides of sheets thinner than the spacing. With signs at random it is half.
constexpr double kOpposite = 0.1;
constexpr double kStandardErrors = 2.5;  // By which the fraction must be larger.

}  // namespace

bool has_unoriented_normals(const PointCloudFile& cloud) {
  if (cloud.normals.empty()) return false;
  std::vector<Eigen::Vector3d> points, normals;
  for (const std::size_t i : some_points(cloud.points.size(), kMostPoints)) {
    points.push_back(cloud.points[i]);
    normals.push_back(cloud.normals[i].cast<double>().stableNormalized());
  }
  const NearestPoints<3> tree(points);
  double alike = 0.0, opposite = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto found = tree.find(points[i], 1);
    if (found.empty()) continue;
    const double cosine = normals[i].dot(normals[found.front().index]);
    if (!(std::abs(cosine) >= kAlike)) continue;
    ++alike;
    if (cosine < 0.0) ++opposite;
  }
  const double fraction = opposite / alike;
  return fraction > kOpposite + kStandardErrors * std::sqrt(fraction * (1.0 - fraction) / alike);
}

std::size_t orient_normals_to_sensor(GridFile& grid) {
  std::size_t turned = 0;
  for (int v = 0; v < grid.normals.height(); ++v) {
    for (int u = 0; u < grid.normals.width(); ++u) {
      Eigen::Vector3f& normal = grid.normals(u, v);
      if (!(normal.cast<double>().dot(grid.camera->ray(u, v).direction) > 0.0)) continue;
      normal = -normal;
      ++turned;
    }
  }
  return turned;
}

}  // namespace relief
