#include "scan/io/project/loading/unorganized_grid.h"

#include <algorithm>
#include <utility>

#include "scan/io/clouds/cloud_grid.h"
#include "scan/io/grids/cameras/grid_samples.h"

namespace relief {

namespace {

// Of a grid that is no picture. A camera that was found errs by less [pixels], also where its
// sensor is no camera: line scanners by 0.3. And samples are no more than so many times as far from
// those beside them as from those below, or the other way round: rings of lidars by up to 20.
constexpr double kNoPicture = 10.0, kFarApart = 30.0;
// Of its points, so many at most have no rays of their own: parallel rays hide half of an object
// that was seen from all around.
constexpr double kLost = 0.4;

}  // namespace

bool is_unorganized(const GridFile& grid, const GridCamera& fitted) {
  if (fitted.camera.can_project() || fitted.rms_pixels < kNoPicture) return false;
  const double across = median_distance_beside(grid.points, 1, 0);
  const double down = median_distance_beside(grid.points, 0, 1);
  return std::min(across, down) > 0.0 &&
         std::max(across, down) > kFarApart * std::min(across, down);
}

std::optional<GridFile> regrid_points(const GridFile& grid,
                                      const std::optional<Eigen::Vector3d>& viewpoint) {
  CloudGridOptions options;
  options.viewpoint = viewpoint;
  PointCloudFile cloud = cloud_of_grid(grid);
  const std::size_t points = cloud.points.size();
  auto found = grid_from_cloud(std::move(cloud), options);
  if (!found || lost_part(*found, points) > kLost) return std::nullopt;
  found->notes.insert(found->notes.begin(),
                      "its rows and columns are no picture; its points are put on a grid of rays");
  return *std::move(found);
}

}  // namespace relief
