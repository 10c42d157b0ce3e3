#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fusion/sparse_field.h"
#include "scan/triangle_mesh.h"

namespace relief {

/// The edge of the lattice from `node` along `axis` (0 to 2).
struct LatticeEdge {
  Node node = Node::Zero();
  int axis = 0;
  Node end() const { return node + Node(Node::Unit(axis)); }
};

/// The zero set of a field as triangles; each vertex lies on one edge of the lattice.
struct Isosurface {
  TriangleMesh mesh;
  std::vector<LatticeEdge> edges;  ///< Of each vertex.
};

/// Extracts the zero set of the field on its active blocks, which close_zero_set has closed. The
/// result is closed, oriented towards positive values, in an order that depends on the field only.
/// Values closer to zero than a thousandth of the spacing are moved to that distance, so that
/// vertices never coincide.
Isosurface extract_isosurface(const SparseField& field, int threads);

}  // namespace relief
