#pragma once

#include <filesystem>
#include <optional>

#include "relief/scan/result.h"
#include "scan/io/workspaces/rgbd/rgbd_layouts.h"

namespace relief {

/// Whether a folder has the list `depth.txt` of a sequence of TUM.
bool has_tum_list(const std::filesystem::path& folder);

/// The file of associations of a folder, if it has one.
std::optional<std::filesystem::path> tum_association_file(const std::filesystem::path& folder);

/// The frames of such a folder in the order of their times. An error where its lists cannot be
/// read, or none of the depth maps is there.
Result<RgbdFrames> tum_frames(const std::filesystem::path& folder);

}  // namespace relief
