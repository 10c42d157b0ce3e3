#pragma once

#include <filesystem>
#include <optional>

#include "relief/scan/result.h"
#include "scan/io/workspaces/rgbd/recordings/recording.h"

namespace relief {

/// Reads `scene_camera.json` of a scene in the format of the BOP benchmark: for each image `cam_K`
/// row by row, `depth_scale` (millimetres of a step), and `cam_R_w2c`, `cam_t_w2c` [mm], view from
/// world. Where no image has these, and `scene_gt.json` has one object in each, poses are those of
/// the camera in the object's frame. Nothing where the folder has no scene_camera.json. kBadInput
/// names what is wrong.
Result<std::optional<Recording>> read_bop_scene(const std::filesystem::path& folder);

}  // namespace relief
