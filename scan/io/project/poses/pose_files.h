#pragma once

#include <filesystem>

#include "relief/io/project_io.h"
#include "relief/scan/result.h"
#include "relief/scan/scan_project.h"

namespace relief {

/// Whether `path` ends like a file that holds poses alone: .aln, .conf, .mlp, .log, .tum.
bool is_pose_path(const std::filesystem::path& path);

/// Whether a pose file of that ending names the grid files of the views: .aln, .conf, .mlp.
bool names_grid_files(const std::filesystem::path& path);

/// Whether write_pose_file() finds a grid file of each view; reads no data of views.
Result<void> check_pose_file(const ScanProject& project, const std::filesystem::path& source,
                             const ReadProjectOptions& source_options,
                             const std::filesystem::path& path);

/// Writes the poses of `project` for other programs, by the ending of `path`:
/// - `.aln`: MeshLab's alignment project; `.mlp`: its project; `.conf`: the Stanford scans' list.
///   They name the grid files of `source`, from which `project` was read. kBadInput when `source`
///   has none: then the views have to be converted to grids first.
/// - `.log`: the trajectory of Open3D and Redwood, world from view, by the order of the views.
/// - `.tum`: a trajectory `time tx ty tz qx qy qz qw`, world from view; the time is the name of the
///   view where that is a number, else its index.
/// Numbers have 17 digits, so that reading them gives the same doubles. Views without a pose are
/// written at the identity.
Result<void> write_pose_file(const ScanProject& project, const std::filesystem::path& source,
                             const ReadProjectOptions& source_options,
                             const std::filesystem::path& path);

}  // namespace relief
