#include "relief/fusion/decimate_mesh.h"

#include <limits>

#include "fusion/mesh/decimation/edge_collapse.h"
#include "scan/mesh/mesh_components.h"

namespace relief::fusion {

Result<DecimatedMesh> decimate_mesh(const TriangleMesh& mesh, const DecimationOptions& options) {
  if (options.faces == 0 && !(options.max_error > 0.0))
    return Error{ErrorKind::kBadInput,
                 "decimation needs a number of faces or a bound of the error"};
  const bool was_closed = check_mesh(mesh).watertight();
  DecimatedMesh result;
  result.mesh = mesh;
  if (options.faces < mesh.faces.size()) {
    EdgeCollapseOptions collapse;
    collapse.faces = options.faces;
    collapse.max_error =
        options.max_error > 0.0 ? options.max_error : std::numeric_limits<double>::infinity();
    collapse.move = true;
    collapse_edges(result.mesh, collapse);
    drop_unused_vertices(result.mesh);
    result.mesh.normals = vertex_normals(result.mesh);
  }
  result.check = check_mesh(result.mesh, {.self_intersections = true});
  if (was_closed && !result.check.watertight())
    return Error{ErrorKind::kUnsolvable,
                 "decimation left the surface no closed manifold; ask for more faces"};
  return result;
}

}  // namespace relief::fusion
