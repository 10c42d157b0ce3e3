#pragma once

#include "scan/io/clouds/files/point_cloud_file.h"
#include "scan/io/grids/grid_file.h"

namespace relief {

/// Whether the normals of a cloud were given signs by something that does not know the sensor, as a
/// fit of planes to the neighbours of each point does: many neighbours have opposite normals along
/// one line. Of what a sensor sees none can be, since both face it. False without normals.
bool signs_of_normals_are_free(const PointCloudFile& cloud);

/// Turns each normal that faces away from the sensor of a grid round; returns how many.
std::size_t turn_normals_to_sensor(GridFile& grid);

}  // namespace relief
