#pragma once

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include "relief/scan/result.h"
#include "scan/io/clouds/files/point_cloud_file.h"
#include "scan/io/grids/grid_file.h"

namespace relief {

struct CloudGridOptions {
  /// Where the sensor is, in the frame of the points [unit]; wins over what the file says.
  std::optional<Eigen::Vector3d> viewpoint;
  /// The direction of view, away from a sensor that is far off. Used without `viewpoint`.
  std::optional<Eigen::Vector3d> direction;
};

/// Puts the points of a cloud that was seen from one place on a grid of rays, about one in each
/// cell. Points stay exactly as they are. The grid's `camera` is that of the rays: perspective from
/// a viewpoint (a ray table with a pinhole's projection; with a spherical one about z where the
/// field of view is 100 degrees or more, which is missing if the viewpoint is not the origin), or
/// orthographic along a direction that is given or found (see find_direction). Where nothing is
/// given, rays from the origin are taken in place of a direction that is found if nearly every
/// point has a ray of its own there, as a sensor measures one point along each.
///
/// Where points share a cell, those up to 3 spacings behind the nearest one are on its surface: the
/// one closest to the middle stays, the others go to a free cell beside it on their own side, or
/// are left out. Points farther behind are hidden and left out, as are those that show through a
/// gap between nearer neighbours. `notes` say how many, and what was assumed.
///
/// Fewer than 12 points stand side by side in one row, without order.
///
/// Errors: kBadInput for normals or colours of another number than points; kUnsolvable for no
/// points, points on a line, or nothing left.
Result<GridFile> grid_from_cloud(PointCloudFile cloud, const CloudGridOptions& options = {});

/// The part of `points` points that have no place on a grid.
double lost_part(const GridFile& grid, std::size_t points);

}  // namespace relief
