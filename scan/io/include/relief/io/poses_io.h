#pragma once

#include <filesystem>
#include <vector>

#include "relief/scan/named_pose.h"
#include "relief/scan/result.h"

namespace relief {

/// Reads the poses of a JSON file whose `views` each have `name` and `world_from_view`: a
/// scan.json, the truth.json of a simulation, or the `align` section of a report. Other keys are
/// not looked at. Errors are kBadInput and name file and view.
Result<std::vector<NamedPose>> read_poses(const std::filesystem::path& path);

}  // namespace relief
