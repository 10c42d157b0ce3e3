#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/camera.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/scan_project.h"

namespace relief {

struct ReadProjectOptions {
  /// Intrinsics of grid files without a camera: `fx fy cx cy`, the model `pinhole_gl`. Empty: the
  /// best-fitting model is found from the points and named in the notes.
  std::filesystem::path fc_file;
  /// Of the depth maps of a folder without a scan.json, in place of its calibration file. Of a
  /// scan.json where a focal length is 0. An option that no view needs is told in the notes.
  std::optional<PinholeIntrinsics> intrinsics;
  /// How many steps of such a depth map are a metre, as 1000; below 1 how many metres a step is, as
  /// 0.001.
  std::optional<double> depth_scale;
  /// Where the sensor stood, in the frame of points without a grid [unit]; for those of which a
  /// scan.json does not tell it as well. Unset: it is found.
  std::optional<Eigen::Vector3d> viewpoint;
  /// Poses that files of scans tell are not taken: the VIEWPOINT of PCD, the matrix of PTX, the
  /// pose of E57. Some programs write a frame there, not a pose.
  bool ignore_viewpoints = false;
  /// Points and meshes without poses are all in one frame, as after an alignment elsewhere: it is
  /// their starting pose. Else nothing is known of the frames of separate files.
  bool shared_frame = false;
  /// Poses are looked for: copies of views without poses are left out, and a pose that the PCD
  /// files of all views tell alike is not taken.
  bool for_alignment = false;
  /// Views that cannot be read are left out, with a note each, as long as there are others. Else
  /// they are an error, which names all of them.
  bool skip_damaged = false;
  /// What all views may take [bytes]: a small file can hold a large image, and many views can name
  /// it. 0: the memory that is free; under a memory limit what the disk of its files has left, and
  /// for one view the memory that is free.
  std::size_t memory = 0;
};

/// Reads what stands for a scan project: a `scan.json`, a Stanford `.conf`, a MeshLab `.aln` or
/// `.mlp`, a file of scans (range-grid PLY, PCD, PTX, E57, text with points, a mesh), a folder of
/// such files, a folder of depth maps, or a COLMAP workspace. Docs: file-formats.md. Errors name
/// file and place: kBadInput; kUnsolvable for views without any sample and for more of them than
/// `memory` holds.
Result<ScanProject> read_project(const std::filesystem::path& path,
                                 const ReadProjectOptions& options = {},
                                 const Context& context = {});

/// The format of views that are written as points on a grid.
enum class GridFormat {
  kPly,  ///< Range-grid PLY in doubles.
  kPcd,  ///< Organized binary PCD in floats.
};

struct WriteProjectOptions {
  /// Every view becomes a grid file: points that other programs read, not images.
  bool grids = false;
  GridFormat grid_format = GridFormat::kPly;
  /// Whether the normal maps say which axes and space their components have.
  bool declare_normals = true;
};

/// Writes `project` as FOLDER/scan.json with one float TIFF of range and, where the view has them,
/// of normals, of confidences and of deviations; views whose rays are a table are written as
/// grid files. Creates the folder. Reading it back gives the same samples to float
/// precision.
Result<void> write_project(const ScanProject& project, const std::filesystem::path& folder,
                           const Context& context = {}, const WriteProjectOptions& options = {});

/// The same for views without a project around them; `unit` is that of their ranges.
Result<void> write_project(const std::vector<RangeView>& views, const std::string& unit,
                           const std::filesystem::path& folder, const Context& context = {},
                           const WriteProjectOptions& options = {});

/// Writes only FILE (a scan.json), for a project whose views' data files exist already: a copy of
/// the project file `source` with the poses of `project` in place of its own, and file names made
/// relative to FILE. A `source` that is no scan.json gets one whose views refer to the original
/// grid files.
Result<void> write_project_poses(const ScanProject& project, const std::filesystem::path& source,
                                 const ReadProjectOptions& source_options,
                                 const std::filesystem::path& file);

/// Reads the poses of a JSON file whose `views` each have `name` and `world_from_view`: a
/// scan.json, the truth.json of a simulation, or the `align` section of a report. Other keys are
/// not looked at. Errors are kBadInput and name file and view.
Result<std::vector<NamedPose>> read_poses(const std::filesystem::path& path);

}  // namespace relief
