#pragma once

#include <filesystem>

#include "scan/io/project/view_spec.h"

namespace relief {

/// Gives the scans or depth maps of a folder without a layout their poses from a file in it, as
/// those of a layout get theirs (frame_poses.h): a trajectory, or a file that names the scans. Only
/// where no scan has a pose of its own, in its file or in one beside it. A note tells which file
/// was taken, or why one that is named as poses was not.
void take_poses_of_folder(const std::filesystem::path& folder, ProjectSpec& project);

}  // namespace relief
