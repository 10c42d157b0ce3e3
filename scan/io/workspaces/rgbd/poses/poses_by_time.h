#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scan/io/workspaces/rgbd/poses/trajectories.h"
#include "scan/io/workspaces/rgbd/rgbd_layouts.h"

namespace relief {

/// The poses of frames by their times: from a list, or the numbers that are their names. Times of
/// the trajectory, or of the frames, may be in milli-, micro- or nanoseconds, where more frames
/// have poses so than in seconds, and more than half of all; a note says so. Nothing where no frame
/// has a pose. `trajectory`: with times.
std::optional<PosesOfFrames> poses_by_time(const Trajectory& trajectory,
                                           const std::vector<RgbdFrame>& frames,
                                           std::vector<std::string>& notes);

}  // namespace relief
