#pragma once

#include <filesystem>
#include <string>

#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

/// Whether the path is that of a tileset: `.json`.
bool is_tileset_path(const std::filesystem::path& path);

/// Writes a mesh in tiles of several levels of detail (tileset.h) and says how many there are.
/// `unit`: of the mesh, see metres_in(). Errors: those of fusion::tile_mesh() and TilesetWriter.
Result<void> export_tiles(const TriangleMesh& mesh, const std::string& unit,
                          const std::filesystem::path& path, const Context& context);

}  // namespace relief
