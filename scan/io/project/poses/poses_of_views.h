#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

/// Whether a file holds poses and no views: a JSON that is no project, a trajectory or a table.
bool holds_poses_alone(const std::filesystem::path& path);

/// World from view of views, by their names: from a JSON as read_poses() takes it, or from any
/// other file of poses that a folder may have (frame_poses.h): by name, time or number, or in the
/// order of the views. `notes`: what was assumed. kBadInput names the file, and the first view
/// without a pose.
Result<std::vector<RigidMotion>> read_poses_of_views(const std::filesystem::path& path,
                                                     const std::vector<std::string>& views,
                                                     std::vector<std::string>& notes);

}  // namespace relief
