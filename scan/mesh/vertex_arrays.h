#pragma once

#include "relief/scan/triangle_mesh.h"

namespace relief {

/// Calls `visit` with each array of a mesh that has one entry per vertex, or is empty.
template <typename Visit>
void visit_vertex_arrays(TriangleMesh& mesh, const Visit& visit) {
  visit(mesh.vertices);
  visit(mesh.normals);
  visit(mesh.quality);
  visit(mesh.views);
  visit(mesh.source_views);
  visit(mesh.filled);
  visit(mesh.colours);
}

}  // namespace relief
