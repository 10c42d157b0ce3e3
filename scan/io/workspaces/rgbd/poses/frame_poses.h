#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "relief/scan/result.h"
#include "scan/io/workspaces/rgbd/poses/trajectories.h"
#include "scan/io/workspaces/rgbd/rgbd_layouts.h"

namespace relief {

/// The pose of each frame; nothing where a frame has none.
using FramePoses = std::vector<std::optional<TrajectoryPose>>;

/// The poses of all frames of a folder: their own, from a trajectory in it, or from a file that
/// names the frames. A note tells which file they are from, or which ones could not be read. Two
/// such files, or a trajectory of another count, are an error.
Result<FramePoses> find_frame_poses(const std::filesystem::path& folder, const RgbdFrames& found,
                                    std::vector<std::string>& notes);

}  // namespace relief
