#include "apps/commands/convert/export_tiles.h"

#include "apps/commands/convert/export_views.h"
#include "apps/console/console.h"
#include "relief/fusion/tile_mesh.h"
#include "relief/io/tileset.h"
#include "scan/io/files/file_ending.h"

namespace relief {

bool is_tileset_path(const std::filesystem::path& path) { return lower_ending(path) == ".json"; }

Result<void> export_tiles(const TriangleMesh& mesh, const std::string& unit,
                          const std::filesystem::path& path, const Context& context) {
  const TilesetWriter writer(path);
  if (auto ready = writer.begin(); !ready) return ready;
  const auto tiles = fusion::tile_mesh(
      mesh, {},
      [&](std::size_t tile, const TriangleMesh& part) { return writer.write_tile(tile, part); },
      context);
  if (!tiles) return tiles.error();
  if (auto written = writer.finish(*tiles, metres_in(unit)); !written) return written;
  Console::info(path.string() + ": " + std::to_string(tiles->size()) + " tiles");
  return {};
}

}  // namespace relief
