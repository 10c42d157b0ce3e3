#pragma once

#include <string>

#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"
#include "relief/simulation/simulation_object.h"

namespace relief::simulation {

/// A triangle mesh as the object of a simulation. Ranges and normals are those of the flat faces,
/// exactly: at facets larger than a sample spacing the scans show facets. The faces must be
/// oriented outwards; a view of a back face gives no sample. The object's sphere holds all
/// vertices, round the centre of their bounding box. kBadInput when the mesh has no area or a
/// vertex that is not finite.
Result<SimulationObject> mesh_object(TriangleMesh mesh, const std::string& unit = "mm");

}  // namespace relief::simulation
