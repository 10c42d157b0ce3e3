#include "scan/io/clouds/files/point_cloud_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <tuple>

#include "relief/io/mesh_io.h"
#include "relief/scan/range_view.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/io/clouds/files/velodyne_bin.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/ply_columns.h"
#include "scan/io/files/ply_file.h"
#include "scan/io/grids/missing_points.h"

namespace relief {

namespace {

bool is_one_of(const std::string& ending, std::initializer_list<const char*> endings) {
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

bool is_text_ending(const std::string& ending) {
  return is_one_of(ending, {".xyz", ".txt", ".asc", ".pts", ".csv", ".xyzn", ".xyzrgb"});
}

bool is_mesh_ending(const std::string& ending) {
  return is_one_of(ending, {".obj", ".stl", ".vtp"});
}

// Keeps the points that are finite, with all that is known of them. Returns how many are left out.
std::size_t keep_finite_points(PointCloudFile& cloud) {
  const std::size_t count = cloud.points.size();
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i)
    if (cloud.points[i].allFinite()) chosen.push_back(i);
  const auto shorten = [&](auto& values) {
    if (values.empty()) return;
    for (std::size_t k = 0; k < chosen.size(); ++k) values[k] = values[chosen[k]];
    values.resize(chosen.size());
  };
  shorten(cloud.points);
  shorten(cloud.normals);
  shorten(cloud.colours);
  shorten(cloud.facing);
  return count - chosen.size();
}

// Makes points NaN that are exactly where an earlier one of the file is.
void invalidate_repeated_points(std::vector<Eigen::Vector3d>& points) {
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t i) {
    return std::make_tuple(points[i].x(), points[i].y(), points[i].z(), i);
  };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t i, std::uint32_t j) { return key(i) < key(j); });
  std::vector<std::uint32_t> repeated;
  for (std::size_t k = 1; k < order.size(); ++k)
    if (points[order[k]] == points[order[k - 1]]) repeated.push_back(order[k]);
  for (const std::uint32_t i : repeated) points[i].setConstant(kNoSample);
}

// Drops what is not finite, what stands twice in the file, and points that stand for missing
// samples.
Result<PointCloudFile> measured_points(PointCloudFile cloud, const std::filesystem::path& path) {
  if (const std::size_t count = keep_finite_points(cloud); count > 0)
    cloud.notes.push_back(std::to_string(count) + " points that are not finite are left out");
  auto missing = cloud.facing.empty() ? invalidate_missing_points(cloud.points)
                                      : invalidate_missing_corners(cloud.points);
  cloud.missing_at_origin |= missing.at_origin;
  if (!missing.notes.empty()) keep_finite_points(cloud);
  std::ranges::move(missing.notes, std::back_inserter(cloud.notes));
  invalidate_repeated_points(cloud.points);
  if (const std::size_t count = keep_finite_points(cloud); count > 0)
    cloud.notes.push_back(std::to_string(count) +
                          " points are where others of the file are, and left out");
  if (cloud.points.empty()) return bad_input(path, "no point of the file is finite and measured");
  if (!cloud.normals.empty() && !hold_directions(cloud.normals)) {
    cloud.normals.clear();
    cloud.notes.emplace_back(kZeroNormalsNote);
  }
  return cloud;
}

template <typename T>
std::vector<T> as_vector(const PagedVector<T>& values) {
  return {values.begin(), values.end()};
}

PointCloudFile cloud_of_mesh(const TriangleMesh& mesh) {
  PointCloudFile cloud;
  if (!mesh.faces.empty()) cloud.facing = as_vector(vertex_normals(mesh));
  cloud.points = as_vector(mesh.vertices);
  cloud.normals = as_vector(mesh.normals);
  cloud.colours = as_vector(mesh.colours);
  return cloud;
}

Colour ply_colour(const PlyColumns& columns, std::size_t i) {
  Colour colour{};
  for (std::size_t k = 0; k < 3; ++k)
    if (const double level = (*columns[k])[i]; level > 0.0)
      colour[k] = static_cast<std::uint8_t>(std::min(level, 255.0));
  return colour;
}

Result<PointCloudFile> cloud_of_ply(const PlyFile& ply, const std::filesystem::path& path) {
  const PlyElement* vertex = ply.find("vertex");
  const auto xyz = vertex ? ply_columns(*vertex, {"x", "y", "z"}) : std::nullopt;
  if (!xyz) return bad_input(path, "no element vertex with the properties x, y and z");
  const auto normal = ply_columns(*vertex, {"nx", "ny", "nz"});
  auto rgb = ply_columns(*vertex, {"red", "green", "blue"});
  if (!rgb) rgb = ply_columns(*vertex, {"diffuse_red", "diffuse_green", "diffuse_blue"});
  PointCloudFile cloud;
  cloud.points.reserve(vertex->count);
  for (std::size_t i = 0; i < vertex->count; ++i) {
    cloud.points.push_back(ply_vector(*xyz, i));
    if (normal) cloud.normals.push_back(ply_vector(*normal, i).cast<float>());
    if (rgb) cloud.colours.push_back(ply_colour(*rgb, i));
  }
  return cloud;
}

Result<PointCloudFile> read_ply_cloud(const std::filesystem::path& path) {
  const auto ply = read_ply(path);
  if (!ply) return ply.error();
  const PlyElement* face = ply->find("face");
  if (!face || face->count == 0) return cloud_of_ply(*ply, path);
  auto mesh = read_mesh(path);
  if (!mesh) return mesh.error();
  return cloud_of_mesh(*mesh);
}

Result<PointCloudFile> read_mesh_cloud(const std::filesystem::path& path) {
  auto mesh = read_mesh(path);
  if (!mesh) return mesh.error();
  return cloud_of_mesh(*mesh);
}

Result<PointCloudFile> read_text_cloud(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return content.error();
  return parse_xyz(*content, path);
}

Result<PointCloudFile> read_pcd_cloud(const std::filesystem::path& path) {
  const auto grid = read_pcd_points(path);
  if (!grid) return grid.error();
  return cloud_of_grid(*grid);
}

}  // namespace

bool has_cloud_ending(const std::filesystem::path& path) {
  const std::string ending = lower_ending(path);
  if (ending == ".bin") return is_velodyne_bin(path);
  return is_text_ending(ending) || is_mesh_ending(ending) || is_one_of(ending, {".pcd", ".ply"});
}

PointCloudFile cloud_of_grid(const GridFile& grid) {
  PointCloudFile cloud;
  for (std::size_t i = 0; i < grid.points.size(); ++i) {
    if (!grid.points[i].allFinite()) continue;
    cloud.points.push_back(grid.points[i]);
    if (!grid.normals.empty()) cloud.normals.push_back(grid.normals[i]);
    if (!grid.colours.empty()) cloud.colours.push_back(grid.colours[i]);
  }
  cloud.world_from_view = grid.world_from_view;
  if (cloud.world_from_view) cloud.viewpoint = Eigen::Vector3d::Zero();
  cloud.missing_at_origin = grid.missing_at_origin;
  cloud.notes = grid.notes;
  return cloud;
}

Result<PointCloudFile> read_point_cloud(const std::filesystem::path& path) {
  const std::string ending = lower_ending(path);
  auto cloud = [&]() -> Result<PointCloudFile> {
    if (is_text_ending(ending)) return read_text_cloud(path);
    if (ending == ".pcd") return read_pcd_cloud(path);
    if (ending == ".bin") return read_velodyne_bin(path);
    if (ending == ".ply") return read_ply_cloud(path);
    if (is_mesh_ending(ending)) return read_mesh_cloud(path);
    return bad_input(path, "unknown format '" + ending +
                               "' of a point cloud; use .xyz, .txt, .asc, .pts, .csv, .pcd, .ply, "
                               ".obj, .stl or .vtp");
  }();
  if (!cloud) return cloud;
  return measured_points(*std::move(cloud), path);
}

}  // namespace relief
