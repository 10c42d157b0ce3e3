#pragma once

#include "fusion/tsdf/sparse_field.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

/// Extracts the zero set of the field on its active blocks, which close_zero_set has closed. The
/// result is a closed manifold, oriented towards positive values, in an order that depends on the
/// field only; each vertex lies on an edge of the lattice.
/// Values closer to zero than a thousandth of the spacing are moved to that distance, so that
/// vertices never coincide. Beside the mesh, memory is that of a few layers of blocks; `memory` may
/// be null.
TriangleMesh extract_isosurface(const SparseField& field, MemoryLimit* memory = nullptr);

}  // namespace relief::fusion
