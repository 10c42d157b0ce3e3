#pragma once

#include "relief/scan/triangle_mesh.h"

namespace relief {

/// A coarser mesh for looking at: one vertex stands for all in a cube of a lattice that face
/// the same way, so that both sides of a thin wall stay apart. It is the one nearest to
/// their mean, with its attributes. Faces that lose a corner go; where others would fold over,
/// clusters are joined. The result need not be a manifold. `cell` is the side of the cubes [unit];
/// larger ones are taken where the lattice would have more than 2^20 of them along an axis. Takes
/// time linear in the size of `mesh` (after Rossignac and Borrel, "Multi-resolution 3D
/// approximations", 1993). `mesh` must have vertices.
TriangleMesh cluster_vertices(const TriangleMesh& mesh, double cell);

}  // namespace relief
