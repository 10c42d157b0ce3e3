#pragma once

#include <cstddef>

#include "relief/scan/mesh_check.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

struct DecimationOptions {
  /// Faces wanted, >= 4; 0: as few as `max_error` allows. More are left where fewer would change
  /// the topology.
  std::size_t faces = 0;
  /// Two vertices become one only where it is no farther than this from the planes of all the
  /// original faces that it then stands for (root of summed squares) [unit]; 0: no bound.
  double max_error = 0.0;
};

struct DecimatedMesh {
  /// Vertices inside lie where they err least, with the attributes of a given vertex nearby. Those
  /// on a border are as given. Normals are renewed.
  TriangleMesh mesh;
  MeshCheck check;  ///< Of `mesh`.
};

/// Joins vertices where the surface is flattest, keeping its topology. Errors: kBadInput when the
/// options ask for nothing; kUnsolvable when a closed manifold does not stay one.
Result<DecimatedMesh> decimate_mesh(const TriangleMesh& mesh, const DecimationOptions& options);

}  // namespace relief::fusion
