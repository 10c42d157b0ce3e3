#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/camera.h"
#include "relief/scan/grid.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

/// From where points were taken as seen.
enum class AssumedViewpoint {
  kNone,    ///< The file or the user says it, or the points are on a grid of the sensor.
  kOrigin,  ///< The origin of the frame, as the points themselves tell.
  kFarOff,  ///< A side of them, along parallel rays.
};

/// A scan file that carries points on the sensor's grid, as it stands in the file.
struct GridFile {
  Grid<Eigen::Vector3d> points;   ///< File's own frame and unit; NaN where there is no sample.
  Grid<Eigen::Vector3f> normals;  ///< As measured, any length; NaN where none. May be empty.
  Grid<float> confidence;         ///< As stored; may be empty.
  Grid<Colour> colours;           ///< May be empty.
  std::optional<RigidMotion> world_from_view;  ///< Where the file tells, as VIEWPOINT of a PCD.
  std::optional<Camera> camera;                ///< Where the file tells the rays.
  AssumedViewpoint assumed_viewpoint = AssumedViewpoint::kNone;  ///< Of points that had no grid.
  bool missing_at_origin = false;  ///< Whether missing samples were there.
  std::vector<std::string> notes;  ///< What was left out or assumed, for the user.
};

/// Reads an organized grid: .ply with `range_grid` or with one vertex per grid place, organized
/// .pcd. Points that are not finite are no samples, nor are those that stand for missing ones, of
/// which notes tell: see missing_points.h. Errors are kBadInput.
Result<GridFile> read_grid_file(const std::filesystem::path& path);

/// The same for each format.
Result<GridFile> read_ply_grid(const std::filesystem::path& path);
Result<GridFile> read_pcd_grid(const std::filesystem::path& path);

/// The points of a PCD of any shape: one that is not organized is a grid of one row.
Result<GridFile> read_pcd_points(const std::filesystem::path& path);

/// Whether the header of a file says that it is such a grid.
bool is_grid_file(const std::filesystem::path& path);

/// Whether the ending of a path is that of a format that can hold a grid.
bool has_grid_ending(const std::filesystem::path& path);

}  // namespace relief
