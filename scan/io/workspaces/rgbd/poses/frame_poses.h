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

/// Whether a file that somebody names holds poses of frames, as those that find_frame_poses() looks
/// for do.
bool holds_frame_poses(const std::filesystem::path& file);

/// The poses of frames in one file, whatever its name, found as in a folder. Notes as there.
/// kBadInput where it holds none, and where they cannot be told to be whose.
Result<FramePoses> read_frame_poses(const std::filesystem::path& file,
                                    const std::vector<RgbdFrame>& frames,
                                    std::vector<std::string>& notes);

}  // namespace relief
