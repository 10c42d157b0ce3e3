#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "scan/io/grids/grid_file.h"

namespace relief {

/// Points without the sensor's grid, as they stand in a file: its own frame and unit.
struct PointCloudFile {
  std::vector<Eigen::Vector3d> points;   ///< All finite.
  std::vector<Eigen::Vector3f> normals;  ///< As stored, any length. Empty, or one for each point.
  bool unoriented_normals = false;       ///< Of each either side may be the right one.
  std::vector<Colour> colours;           ///< Empty, or one for each point.
  /// Unit normals from the faces of a mesh, on the side where faces wind counter-clockwise; zero
  /// where a point has no face. No measurement: they only tell the side. Empty, or one each.
  std::vector<Eigen::Vector3f> facing;
  std::optional<RigidMotion> world_from_view;  ///< Where the file tells, as VIEWPOINT of a PCD.
  std::optional<Eigen::Vector3d> viewpoint;    ///< Where the sensor is in the points' frame.
  /// Whether missing samples were at the origin: that is where the sensor was.
  bool missing_at_origin = false;
  std::vector<std::string> notes;  ///< What was left out or assumed, for the user.
};

/// Reads points by the ending of `path`, in lower or upper case:
/// - `.xyz .txt .asc .pts .csv .xyzn .xyzrgb`: text, see parse_xyz;
/// - `.pcd`: points of a PCD, organized or not; its VIEWPOINT is the pose;
/// - `.ply`: the vertices of a cloud or of a mesh, with `nx ny nz` and `red green blue`;
/// - `.bin`: floats of a lidar, see velodyne_bin.h;
/// - `.obj .stl .vtp`: the vertices of a mesh; equal corners of an STL are one point.
/// Points that are not finite are left out, as are several at the origin, which many programs write
/// where nothing was measured, and points exactly where an earlier one is. `notes` say how many.
/// Errors (kBadInput) name the file and the place in it; a file without a point is one.
Result<PointCloudFile> read_point_cloud(const std::filesystem::path& path);

/// Whether read_point_cloud knows the ending of `path`. Of a `.bin`, which others write too, the
/// points tell.
bool has_cloud_ending(const std::filesystem::path& path);

/// Text with a point in each line: numbers with blanks, tabs, commas or semicolons between them.
/// Lines that are empty or begin with `#` or `//` are skipped. A line with one whole number says
/// how many points follow (PTS).
///
/// Columns are named by a line before the first point, also behind `#` or `//`: `x y z`, `nx ny
/// nz`, `r g b` or `red green blue`, `intensity`; others are not read. Without names, the first
/// three are x y z. Further ones are normals (three that have unit length within 2 % for 95 % of
/// the points), colours (three whole numbers from 0 to 255) and an intensity (one). Intensities
/// become grey where there are no colours, see GreyOfIntensity.
///
/// Errors (kBadInput) name the line; columns without names that fit nothing of this, or fewer
/// points than promised, are errors. More points than promised are read and noted.
Result<PointCloudFile> parse_xyz(std::string_view content, const std::filesystem::path& path);

/// The points of a grid without their order: for grids of one row or column. Where the grid has a
/// pose, its sensor stands at the origin.
PointCloudFile cloud_of_grid(const GridFile& grid);

}  // namespace relief
