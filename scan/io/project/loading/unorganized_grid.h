#pragma once

#include <optional>

#include <Eigen/Core>

#include "scan/io/grids/cameras/grid_camera.h"
#include "scan/io/grids/grid_file.h"

namespace relief {

/// Whether the rows and columns of a file do not organize its points as a picture: no camera
/// explains them, and neighbours are far apart one way. Lidars with several mirrors store each
/// one's points in a column. `fitted`: the best camera for the grid.
bool is_unorganized(const GridFile& grid, const GridCamera& fitted);

/// The points of a grid on rays of their own (grid_from_cloud), seen from `viewpoint` if that is
/// given. Nothing where most of them hide each other.
std::optional<GridFile> regrid_points(const GridFile& grid,
                                      const std::optional<Eigen::Vector3d>& viewpoint);

}  // namespace relief
