#pragma once

#include <cstddef>

#include "scan/io/clouds/files/point_cloud_file.h"
#include "scan/io/grids/grid_file.h"

namespace relief {

/// Whether the normals of a cloud have no orientation, as those of planes that were fitted to the
/// neighbours of each point: many neighbours have opposite normals along one line. Where a sensor
/// sees both points, both normals would face it. False without normals.
bool has_unoriented_normals(const PointCloudFile& cloud);

/// Turns each normal that faces away from the sensor of a grid round; returns how many.
std::size_t orient_normals_to_sensor(GridFile& grid);

}  // namespace relief
