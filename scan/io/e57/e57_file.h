#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "scan/io/grids/grid_file.h"

namespace relief {

/// What an E57 file (ASTM E2807) tells about one of its scans.
struct E57ScanInfo {
  std::string name;        ///< May be empty.
  std::string guid;        ///< May be empty.
  std::size_t points = 0;  ///< Records, those without a valid point included.
  /// From the scan's frame to that of the file; nothing when the file tells no pose, in which case
  /// the points are in the frame of the file.
  std::optional<RigidMotion> world_from_view;
  bool has_indices = false;  ///< Its points tell their row and column.
  bool has_normals = false, has_colours = false, has_intensity = false;
};

/// The valid points of one scan in the order of the file. All vectors but `points` are empty or
/// have its size.
struct E57Cloud {
  std::string name, guid;
  std::vector<Eigen::Vector3d> points;   ///< The scan's own frame [m]; finite, none at the origin.
  std::vector<Eigen::Vector3f> normals;  ///< The same frame, as stored; NaN where there is none.
  /// 8-bit colours, else grey by intensity; black where the file calls a colour invalid.
  std::vector<Colour> colours;
  /// Whether the points tell their place on a grid of at least two rows and two columns.
  bool structured = false;
  std::vector<int> rows, columns;  ///< Only of a structured scan; counted from 0.
  int width = 0, height = 0;       ///< Of that grid; rows and columns are below.
  std::optional<RigidMotion> world_from_view;
  std::vector<std::string> notes;  ///< What was left out or assumed, for the user.
};

/// The scans of a file, from its XML section alone. kBadInput names the place in the file.
Result<std::vector<E57ScanInfo>> list_e57_scans(const std::filesystem::path& path);
Result<std::vector<E57ScanInfo>> parse_e57_scans(std::string_view content,
                                                 const std::filesystem::path& path);

/// Scan number `scan`, counted from 0. Records whose invalid state says so, points that are not
/// finite and points exactly at the scan's origin are left out and counted in the notes. Every page
/// that is read has its checksum checked. kBadInput names the page, the packet or the element of
/// the XML section that is wrong, or says that there is no such scan.
Result<E57Cloud> read_e57_cloud(const std::filesystem::path& path, int scan);
Result<E57Cloud> parse_e57_cloud(std::string_view content, const std::filesystem::path& path,
                                 int scan);

/// The same for a structured scan, on its grid: u is the column, v the row. Of several points at
/// one place the nearest to the scan's origin is kept. kBadInput for an unstructured scan, and for
/// a grid that is nearly empty (see docs/file-formats.md).
Result<GridFile> read_e57_scan(const std::filesystem::path& path, int scan);
Result<GridFile> parse_e57_scan(std::string_view content, const std::filesystem::path& path,
                                int scan);

/// Whether a structured scan lost most of its points after it was measured: three quarters have no
/// neighbour in their row of the grid, or the grid is far too large for them. Such points are
/// better taken as a cloud.
bool is_thinned_out(const E57Cloud& cloud);

/// Puts a structured cloud on its grid; `path` is for messages.
Result<GridFile> grid_from_e57_cloud(E57Cloud cloud, const std::filesystem::path& path);

/// Writes each view as a structured scan: points as 64-bit floats in the view's frame, rows and
/// columns, colours, normals, the pose unless it is absent, and the name. One unit of the views is
/// `metres_per_unit` metres; coordinates are exact when that is 1. Confidences and deviations have
/// no place in the format. The same views give the same bytes. kBadInput when `metres_per_unit` is
/// not positive; kCannotWrite as write_atomically.
Result<void> write_e57(const std::vector<RangeView>& views, const std::filesystem::path& path,
                       double metres_per_unit = 1.0);
Result<std::string> encode_e57(const std::vector<RangeView>& views, double metres_per_unit = 1.0);

}  // namespace relief
