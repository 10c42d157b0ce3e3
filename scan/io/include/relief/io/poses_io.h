#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

struct NamedPose {
  std::string name;
  RigidMotion world_from_view = RigidMotion::Identity();
};

/// Reads the poses of a JSON file whose `views` each have `name` and `world_from_view`: a
/// scan.json, the truth.json of a simulation, or the `align` section of a report. Other keys are
/// not looked at. Errors are kBadInput and name file and view.
Result<std::vector<NamedPose>> read_poses(const std::filesystem::path& path);

}  // namespace relief
