#pragma once

#include "scan/io/grids/grid_file.h"

namespace relief {

/// Whether the normals of a grid can tell on which side of the surface the sensor is. They can
/// unless, as directions without sign, they agree better with the surface when axes are reversed or
/// swapped: then their convention is wrong and their signs mean nothing yet.
bool normals_tell_side(const GridFile& grid);

}  // namespace relief
