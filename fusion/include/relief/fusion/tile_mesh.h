#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "relief/scan/context.h"
#include "relief/scan/mesh_tile.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

struct TileOptions {
  /// Most faces of a tile, >= 100; its border may add some.
  std::size_t faces = 50000;
};

/// Stores the mesh of a tile by its number. Called from several threads at once, children before
/// their parent.
using StoreTile = std::function<Result<void>(std::size_t tile, const TriangleMesh& mesh)>;

/// Cuts a mesh into tiles in several levels of detail, for viewers of meshes that are too large to
/// load at once. The cubes of an octree hold the faces by their centres and are divided until they
/// have few enough. Each larger cube gets what its parts have, with a quarter of the faces, by the
/// collapse of edges as in decimate_mesh(). Vertices on the border of a tile all stay, so any
/// choice of tiles that shows each part once closes without cracks where the mesh is closed. All
/// vertices are vertices of `mesh`, with their attributes.
///
/// Gives the tiles by number; the first is the whole mesh. Errors: kBadInput when the mesh has no
/// faces or the options ask for less than 100 faces; those of `store`.
Result<std::vector<MeshTile>> tile_mesh(const TriangleMesh& mesh, const TileOptions& options,
                                        const StoreTile& store, const Context& context = {});

}  // namespace relief::fusion
