#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "relief/scan/range_view.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/ply_columns.h"
#include "scan/io/files/ply_file.h"
#include "scan/io/grids/grid_file.h"
#include "scan/io/grids/missing_points.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

Result<int> grid_side(const PlyFile& ply, const char* key, const std::filesystem::path& path) {
  const auto found = ply.object_info.find(key);
  if (found == ply.object_info.end())
    return bad_input(path, std::string("this PLY is no scan grid: its header has no 'obj_info ") +
                               key + "'; a scan needs the sensor's grid, a mesh alone will not do");
  const std::string& text = found->second;
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value <= 0 ||
      value > kMaxImageSide)
    return bad_input(path, std::string("obj_info ") + key + " is '" + text +
                               "'; expected a count of grid places");
  return value;
}

// Which vertex lies at each place of the grid; -1 where none does.
Result<Grid<std::int64_t>> read_places(const PlyFile& ply, std::size_t vertices, int width,
                                       int height, const std::filesystem::path& path) {
  const auto size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const std::string shape =
      std::to_string(width) + " columns x " + std::to_string(height) + " rows";
  const PlyElement* grid = ply.find("range_grid");
  const std::size_t places = grid ? grid->count : vertices;
  if (places != size)
    return bad_input(path, std::string(grid ? "element range_grid" : "element vertex") + " has " +
                               std::to_string(places) + " entries, but obj_info says " + shape);
  Grid<std::int64_t> vertex(width, height, -1);
  if (!grid) {
    for (std::size_t i = 0; i < size; ++i) vertex[i] = static_cast<std::int64_t>(i);
    return vertex;
  }
  const PlyProperty* list = nullptr;
  for (const auto& property : grid->properties)
    if (property.is_list) list = &property;
  if (!list) return bad_input(path, "element range_grid has no list property vertex_indices");
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t length = list->starts[i + 1] - list->starts[i];
    if (length == 0) continue;
    const double index = list->values[list->starts[i]];
    if (length > 1 || !(index >= 0.0 && index < static_cast<double>(vertices)))
      return bad_input(
          path, "range_grid " + std::to_string(i) + ": " +
                    (length > 1 ? std::to_string(length) + " vertices at one place"
                                : "vertex index " + std::to_string(index) + " is outside 0.." +
                                      std::to_string(vertices - 1)));
    vertex[i] = static_cast<std::int64_t>(index);
  }
  return vertex;
}

Result<Colour> colour_at(const PlyColumns& columns, std::size_t i,
                         const std::filesystem::path& path) {
  const Eigen::Vector3d values = ply_vector(columns, i);
  Colour colour{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double value = values[static_cast<Eigen::Index>(k)];
    if (!(value >= 0.0 && value <= 255.0) || value != std::floor(value))
      return bad_input(path, "vertex " + std::to_string(i) +
                                 ": red, green and blue are whole numbers from 0 to 255");
    colour[k] = static_cast<std::uint8_t>(value);
  }
  return colour;
}

}  // namespace

Result<GridFile> read_ply_grid(const std::filesystem::path& path) {
  auto ply = read_ply(path);
  if (!ply) return ply.error();
  const auto width = grid_side(*ply, "num_cols", path);
  if (!width) return width.error();
  const auto height = grid_side(*ply, "num_rows", path);
  if (!height) return height.error();
  const PlyElement* vertex = ply->find("vertex");
  const auto xyz = vertex ? ply_columns(*vertex, {"x", "y", "z"}) : std::nullopt;
  if (!xyz) return bad_input(path, "no element vertex with the properties x, y and z");
  const auto places = read_places(*ply, vertex->count, *width, *height, path);
  if (!places) return places.error();

  const auto normal = ply_columns(*vertex, {"nx", "ny", "nz"});
  const auto rgb = ply_columns(*vertex, {"red", "green", "blue"});
  const PlyProperty* confidence = vertex->find("confidence");
  if (confidence && confidence->is_list) confidence = nullptr;
  GridFile grid;
  grid.points = Grid<Eigen::Vector3d>(*width, *height, Eigen::Vector3d::Constant(kNoSample));
  const Eigen::Vector3f no_normal = Eigen::Vector3f::Constant(static_cast<float>(kNoSample));
  if (normal) grid.normals = Grid<Eigen::Vector3f>(*width, *height, no_normal);
  if (confidence) grid.confidence = Grid<float>(*width, *height, 0.0f);
  if (rgb) grid.colours = Grid<Colour>(*width, *height, Colour{});
  for (std::size_t i = 0; i < places->size(); ++i) {
    if ((*places)[i] < 0) continue;
    const auto v = static_cast<std::size_t>((*places)[i]);
    const Eigen::Vector3d point = ply_vector(*xyz, v);
    if (!point.allFinite()) continue;
    grid.points[i] = point;
    if (normal) grid.normals[i] = ply_vector(*normal, v).cast<float>();
    if (confidence) grid.confidence[i] = static_cast<float>(confidence->values[v]);
    if (!rgb) continue;
    const auto colour = colour_at(*rgb, v, path);
    if (!colour) return colour.error();
    grid.colours[i] = *colour;
  }
  auto missing = invalidate_missing_points({grid.points.begin(), grid.points.end()});
  grid.missing_at_origin = missing.at_origin;
  grid.notes = std::move(missing.notes);
  return grid;
}

}  // namespace relief
