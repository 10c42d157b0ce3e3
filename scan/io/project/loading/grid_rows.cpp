#include "scan/io/project/loading/grid_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "scan/base/median.h"
#include "scan/io/clouds/cloud_grid.h"

namespace relief {

namespace {

// Of a grid that is no picture. A camera that was found errs by less [pixels], also where its
// sensor is no camera: line scanners by 0.3. And samples are no more than so many times as far from
// those beside them as from those below, or the other way round: rings of lidars by up to 20.
constexpr double kNoPicture = 10.0, kFarApart = 30.0;
// Of its points, so many have rays of their own: parallel rays hide half of an object that was seen
// from all around.
constexpr double kOnRays = 0.6;

double median_distance(const Grid<Eigen::Vector3d>& points, int du, int dv) {
  std::vector<double> distances;
  for (int v = 0; v + dv < points.height(); ++v)
    for (int u = 0; u + du < points.width(); ++u)
      if (const double distance = (points(u + du, v + dv) - points(u, v)).norm();
          std::isfinite(distance))
        distances.push_back(distance);
  return median(std::move(distances));
}

}  // namespace

bool is_no_picture(const GridFile& grid, const GridCamera& fitted) {
  if (fitted.camera.can_project() || fitted.rms_pixels < kNoPicture) return false;
  const double across = median_distance(grid.points, 1, 0);
  const double down = median_distance(grid.points, 0, 1);
  return std::min(across, down) > 0.0 &&
         std::max(across, down) > kFarApart * std::min(across, down);
}

std::optional<GridFile> without_rows(const GridFile& grid,
                                     const std::optional<Eigen::Vector3d>& viewpoint) {
  CloudGridOptions options;
  options.viewpoint = viewpoint;
  PointCloudFile cloud = cloud_of_grid(grid);
  const auto points = static_cast<double>(cloud.points.size());
  auto found = grid_from_cloud(std::move(cloud), options);
  if (!found) return std::nullopt;
  const auto kept = std::ranges::count_if(
      found->points, [](const Eigen::Vector3d& point) { return point.allFinite(); });
  if (static_cast<double>(kept) < kOnRays * points) return std::nullopt;
  found->notes.insert(found->notes.begin(),
                      "its rows and columns are no picture; its points are put on a grid of rays");
  return *std::move(found);
}

}  // namespace relief
