#pragma once

#include <filesystem>
#include <vector>

#include "relief/scan/result.h"
#include "scan/io/grids/grid_file.h"
#include "scan/io/project/view_spec.h"

namespace relief {

/// Whether the ending of a path, in lower or upper case, is that of a file of scans: grids (.ply
/// .pcd .ptx .e57), or points and meshes without a grid.
bool has_scan_ending(const std::filesystem::path& path);

/// What a file of scans is by its ending and its header.
enum class ScanFileKind {
  kGrid,    ///< Points on the sensor's grid: a range-grid .ply, an organized .pcd.
  kScans,   ///< One scan or several, each with or without a grid: .ptx, .e57.
  kPoints,  ///< Points or a mesh without a grid.
  kOther,   ///< A .pcd without points, as of normals alone.
  kNone,    ///< The ending is not that of a file of scans.
};
ScanFileKind kind_of_scan_file(const std::filesystem::path& path);

/// What tells each scan of a file from the others; at least one. kBadInput names the file and the
/// place in it.
Result<std::vector<GridOptions>> list_scans(const std::filesystem::path& path);

/// Reads one scan of a file. Points without a grid are put on one, see grid_from_cloud(). kBadInput
/// names the file and the place in it.
Result<GridFile> read_scan_file(const std::filesystem::path& path, const GridOptions& options = {});

}  // namespace relief
