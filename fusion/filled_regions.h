#pragma once

#include "scan/triangle_mesh.h"

namespace relief {

/// The part of the surface's area in faces with a filled vertex.
double filled_area_fraction(const TriangleMesh& mesh);

/// Drops the faces at filled vertices, region by region (filled vertices joined by edges), of the
/// regions that have a vertex farther than `largest` [unit] from what was measured (`quality` of
/// filled vertices). Vertices no face uses go as well.
void open_holes(TriangleMesh& mesh, double largest);

}  // namespace relief
