#pragma once

#include "relief/scan/triangle_mesh.h"

namespace relief::simulation {

/// The unit sphere as a closed mesh: each edge of an icosahedron is split into `divisions` >= 1
/// parts and all points are moved to the sphere. 10 divisions^2 + 2 vertices, 20 divisions^2 faces.
TriangleMesh geodesic_sphere(int divisions);

}  // namespace relief::simulation
