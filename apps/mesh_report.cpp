#include "apps/mesh_report.h"

namespace relief {

Json to_json(const MeshCheck& check) {
  return {{"vertices", check.vertices},
          {"faces", check.faces},
          {"watertight", check.watertight()},
          {"manifold_edges", check.non_manifold_edges == 0},
          {"manifold_vertices", check.non_manifold_vertices == 0},
          {"oriented", check.inconsistent_edges == 0},
          {"boundary_edges", check.boundary_edges},
          {"components", check.components},
          {"genus", check.genus},
          {"volume", check.volume},
          {"non_manifold_edges", check.non_manifold_edges},
          {"non_manifold_vertices", check.non_manifold_vertices},
          {"inconsistent_edges", check.inconsistent_edges},
          {"degenerate_faces", check.degenerate_faces},
          {"duplicate_vertices", check.duplicate_vertices},
          {"unused_vertices", check.unused_vertices}};
}

}  // namespace relief
