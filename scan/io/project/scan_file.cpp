#include "scan/io/project/scan_file.h"

#include <algorithm>
#include <string>
#include <utility>

#include "scan/io/clouds/cloud_grid.h"
#include "scan/io/clouds/files/point_cloud_file.h"
#include "scan/io/clouds/files/ptx_file.h"
#include "scan/io/e57/e57_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/grids/pcd_header.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

PointCloudFile cloud_of_e57(E57Cloud e57) {
  PointCloudFile cloud;
  cloud.points = std::move(e57.points);
  cloud.normals = std::move(e57.normals);
  cloud.colours = std::move(e57.colours);
  cloud.world_from_view = e57.world_from_view;
  cloud.notes = std::move(e57.notes);
  return cloud;
}

Result<GridFile> grid_of(Result<PointCloudFile> cloud, const fs::path& path,
                         const GridOptions& options) {
  if (!cloud) return cloud.error();
  if (options.ignore_pose) {
    cloud->world_from_view.reset();
    cloud->viewpoint.reset();
  }
  CloudGridOptions grid_options;
  grid_options.viewpoint = options.viewpoint;
  auto grid = grid_from_cloud(std::move(*cloud), grid_options);
  if (!grid) return Error{grid.error().kind, path.string() + ": " + grid.error().message};
  return grid;
}

Result<GridFile> read_ptx_scan(const fs::path& path, const GridOptions& options, PtxMatrix matrix) {
  return options.ptx ? read_ptx_scan(path, *options.ptx, matrix)
                     : read_ptx_scan(path, options.scan, matrix);
}

// A matrix that is no rigid motion cannot be a pose. Points that it is applied to are in the world.
Result<GridFile> read_in_world(const fs::path& path, const GridOptions& options, const Error& why) {
  auto grid = read_ptx_scan(path, options, PtxMatrix::kApply);
  if (!grid) return grid;
  grid->world_from_view = RigidMotion::Identity();
  grid->notes.push_back("the matrix was applied to the points: " + why.message);
  return grid;
}

// One row or column of points is no grid.
Result<GridFile> read_ptx(const fs::path& path, const GridOptions& options) {
  auto grid = read_ptx_scan(path, options, PtxMatrix::kPose);
  if (!grid) grid = read_in_world(path, options, grid.error());
  if (!grid || (grid->points.width() > 1 && grid->points.height() > 1)) return grid;
  return grid_of(cloud_of_grid(*grid), path, options);
}

// Without poses the scans of one file are in its frame. A file of one scan may be one of many, each
// in a frame of its own: then nothing is known.
Result<void> complete_pose(const fs::path& path, E57Cloud& cloud) {
  if (cloud.world_from_view) return {};
  const auto scans = list_e57_scans(path);
  if (!scans) return scans.error();
  if (scans->size() > 1) cloud.world_from_view = RigidMotion::Identity();
  return {};
}

// An unstructured scan has no grid; its points are put on one, as are those of a scan that was
// thinned out.
Result<GridFile> read_e57(const fs::path& path, const GridOptions& options) {
  auto cloud = read_e57_cloud(path, options.scan);
  if (!cloud) return cloud.error();
  const bool has_pose = cloud->world_from_view.has_value();
  if (auto completed = complete_pose(path, *cloud); !completed) return completed.error();
  if (cloud->structured && !is_thinned_out(*cloud))
    return grid_from_e57_cloud(std::move(*cloud), path);
  PointCloudFile points = cloud_of_e57(std::move(*cloud));
  // A scan with a pose of its own has the scanner at its origin.
  if (has_pose) points.viewpoint = Eigen::Vector3d::Zero();
  return grid_of(std::move(points), path, options);
}

Result<GridFile> read_any(const fs::path& path, const GridOptions& options) {
  const std::string ending = lower_ending(path);
  if (ending == ".ptx") return read_ptx(path, options);
  if (ending == ".e57") return read_e57(path, options);
  if (options.scan != 0)
    return bad_input(path, "holds one scan, numbered 0, not scan " + std::to_string(options.scan));
  switch (kind_of_scan_file(path)) {
    case ScanFileKind::kGrid:
      return read_grid_file(path);
    case ScanFileKind::kPoints:
    case ScanFileKind::kOther:  // The reader says what is missing.
      return grid_of(read_point_cloud(path), path, options);
    default:
      return bad_input(path, "unknown scan format '" + path.extension().string() +
                                 "'; use .ply, .pcd, .ptx, .e57, .xyz, .pts, .obj, .stl or .vtp");
  }
}

}  // namespace

bool has_scan_ending(const fs::path& path) {
  return kind_of_scan_file(path) != ScanFileKind::kNone;
}

ScanFileKind kind_of_scan_file(const fs::path& path) {
  const std::string ending = lower_ending(path);
  if (ending == ".ptx" || ending == ".e57") return ScanFileKind::kScans;
  if (ending == ".ply") return is_grid_file(path) ? ScanFileKind::kGrid : ScanFileKind::kPoints;
  if (ending == ".pcd") {
    // What cannot be read is left to the reader of grids, which says why.
    const auto header = read_pcd_header(path, /*organized=*/false);
    if (header && !header->has_position) return ScanFileKind::kOther;
    const bool grid = !header || (header->height > 1 && header->width > 1);
    return grid ? ScanFileKind::kGrid : ScanFileKind::kPoints;
  }
  return has_cloud_ending(path) ? ScanFileKind::kPoints : ScanFileKind::kNone;
}

Result<std::vector<GridOptions>> list_scans(const fs::path& path) {
  const std::string ending = lower_ending(path);
  std::vector<GridOptions> options(1);
  if (ending == ".ptx") {
    const auto scans = list_ptx_scans(path);
    if (!scans) return scans.error();
    options.resize(scans->size());
    for (std::size_t i = 0; i < scans->size(); ++i) options[i].ptx = (*scans)[i];
  } else if (ending == ".e57") {
    const auto scans = list_e57_scans(path);
    if (!scans) return scans.error();
    if (scans->empty())
      return bad_input(path,
                       "holds no scan (data3D is empty), only other data; export it with its point "
                       "clouds");
    options.resize(scans->size());
  }
  for (std::size_t i = 0; i < options.size(); ++i) options[i].scan = static_cast<int>(i);
  return options;
}

Result<GridFile> read_scan_file(const fs::path& path, const GridOptions& options) {
  auto grid = read_any(path, options);
  if (grid && options.ignore_pose) grid->world_from_view.reset();
  return grid;
}

}  // namespace relief
