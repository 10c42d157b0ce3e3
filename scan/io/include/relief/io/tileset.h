#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "relief/scan/mesh_tile.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

/// A mesh in tiles as OGC 3D Tiles 1.1, for viewers such as CesiumJS: `NAME.json` tells the tree,
/// `NAME_tiles/NUMBER.glb` beside it hold the tiles.
class TilesetWriter {
 public:
  /// `path`: the `.json` file.
  explicit TilesetWriter(std::filesystem::path path);

  /// Makes the folder of the tiles, and removes an older tileset. kCannotWrite, also where the
  /// `.json` is something else.
  Result<void> begin() const;
  /// Writes a tile in the coordinates of the whole mesh. From any thread. kCannotWrite.
  Result<void> write_tile(std::size_t number, const TriangleMesh& mesh) const;
  /// Writes the tree, the first tile as its root, when all tiles are there, and removes tiles of an
  /// older and larger set. 3D Tiles are in metres; `metres_per_unit`: of the mesh. Viewers refine a
  /// tile whose geometric error is too large on the screen: it is eight times the mean length of
  /// its edges, so they are at most 2 pixels long where a viewer admits 16 (CesiumJS as it comes).
  /// That of the most detailed tiles is 0. kCannotWrite.
  Result<void> finish(const std::vector<MeshTile>& tiles, double metres_per_unit) const;

 private:
  std::filesystem::path tile_file(std::size_t number) const;

  std::filesystem::path path_, folder_;
};

}  // namespace relief
