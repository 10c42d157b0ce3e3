#pragma once

#include <filesystem>

#include "relief/scan/result.h"

namespace relief {

/// Why a file does not stand for a project, by its ending: what it seems to be, and what to give in
/// its place. kBadInput.
Error why_no_project(const std::filesystem::path& path);

/// Whether a file that could be a project or points by its ending holds what belongs to a folder of
/// depth maps: a trajectory, lists of images, or a camera of Open3D.
bool belongs_to_depth_maps(const std::filesystem::path& path);

}  // namespace relief
