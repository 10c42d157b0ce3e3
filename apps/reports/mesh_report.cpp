#include "apps/reports/mesh_report.h"

#include <algorithm>
#include <vector>

namespace relief {

namespace {

// A report is for reading: a mesh that is broken all over does not need all its faces listed.
constexpr std::size_t kListedFaces = 100;

}  // namespace

Json to_json(const MeshCheck& check) {
  Json json = {{"vertices", check.vertices},
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
  if (check.self_intersections) {
    const auto faces = check.self_intersections->faces();
    json["self_intersections"] = check.self_intersections->pairs.size();
    json["self_intersections_complete"] = check.self_intersections->complete;
    json["self_intersecting_faces"] = std::vector(
        faces.begin(), faces.begin() + static_cast<long>(std::min(faces.size(), kListedFaces)));
  }
  return json;
}

}  // namespace relief
