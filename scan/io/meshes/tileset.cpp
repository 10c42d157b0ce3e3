// OGC 3D Tiles 1.1 (22-025r4).
#include "relief/io/tileset.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "relief/io/mesh_io.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/io_error.h"

namespace relief {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Geometric error of a tile in lengths of its edges: these are 2 pixels where 16 are admitted.
constexpr double kErrorOfEdge = 8.0;

// Viewers turn glTF, whose second axis is up, so that the third is: (x, y, z) -> (x, -z, y).
Json box_as_turned(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d centre = box.center(), half = box.sizes() / 2.0;
  return {{"box",
           {centre.x(), -centre.z(), centre.y(), half.x(), 0, 0, 0, half.z(), 0, 0, 0, half.y()}}};
}

// Turns back, to the axes of the mesh, and scales to metres; columns one behind the other.
Json transform_to_metres(double scale) {
  return {scale, 0, 0, 0, 0, 0, -scale, 0, 0, scale, 0, 0, 0, 0, 0, 1};
}

// Of each tile; no tile has less than those below it.
std::vector<double> geometric_errors(const std::vector<MeshTile>& tiles) {
  std::vector<double> errors(tiles.size(), 0.0);
  for (std::size_t i = tiles.size(); i-- > 0;) {
    if (tiles[i].children.empty()) continue;
    errors[i] = kErrorOfEdge * tiles[i].edge_length;
    for (const std::size_t child : tiles[i].children)
      errors[i] = std::max(errors[i], errors[child]);
  }
  return errors;
}

// As in a link: all but letters, digits and `-._~` as %XX (RFC 3986).
std::string link_text(const std::string& name) {
  std::string text;
  for (const unsigned char byte : name) {
    if (std::isalnum(byte) || std::string_view("-._~").find(byte) != std::string_view::npos) {
      text += static_cast<char>(byte);
    } else {
      char escaped[4];
      std::snprintf(escaped, sizeof escaped, "%%%02X", byte);
      text += escaped;
    }
  }
  return text;
}

// Other files of that name, as projects, are not to be lost.
bool is_tileset(const fs::path& path) {
  const auto text = read_file(path);
  if (!text) return false;
  const auto json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  return json.is_object() && json.contains("asset") && json.contains("geometricError");
}

std::string file_name(std::size_t number) { return std::to_string(number) + ".glb"; }

Json tile_json(const std::vector<MeshTile>& tiles, const std::vector<double>& errors,
               const std::string& folder, std::size_t number) {
  Json json = {{"boundingVolume", box_as_turned(tiles[number].box)},
               {"geometricError", errors[number]},
               {"content", {{"uri", folder + "/" + file_name(number)}}}};
  for (const std::size_t child : tiles[number].children)
    json["children"].push_back(tile_json(tiles, errors, folder, child));
  return json;
}

}  // namespace

TilesetWriter::TilesetWriter(fs::path path)
    : path_(std::move(path)), folder_(path_.parent_path() / (path_.stem().string() + "_tiles")) {}

fs::path TilesetWriter::tile_file(std::size_t number) const { return folder_ / file_name(number); }

Result<void> TilesetWriter::begin() const {
  std::error_code code;
  if (fs::exists(path_, code) && !is_tileset(path_))
    return cannot_write(path_, "it is there and is no tileset; name another file");
  fs::create_directories(folder_, code);
  if (code) return cannot_write(folder_, code.message());
  fs::remove(path_, code);
  if (code) return cannot_write(path_, code.message());
  return {};
}

Result<void> TilesetWriter::write_tile(std::size_t number, const TriangleMesh& mesh) const {
  return write_mesh(mesh, tile_file(number));
}

Result<void> TilesetWriter::finish(const std::vector<MeshTile>& tiles,
                                   double metres_per_unit) const {
  std::error_code code;
  for (std::size_t old = tiles.size(); fs::remove(tile_file(old), code); ++old) {
  }
  const auto errors = geometric_errors(tiles);
  Json root = tile_json(tiles, errors, link_text(folder_.filename().string()), 0);
  root["transform"] = transform_to_metres(metres_per_unit);
  root["refine"] = "REPLACE";
  const Json tileset = {{"asset", {{"version", "1.1"}, {"generator", "relief"}}},
                        {"geometricError", tiles[0].box.diagonal().norm() * metres_per_unit},
                        {"root", std::move(root)}};
  return write_file(path_, tileset.dump(1) + "\n");
}

}  // namespace relief
