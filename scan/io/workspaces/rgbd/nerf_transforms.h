#pragma once

#include <filesystem>
#include <string_view>

#include "relief/scan/result.h"
#include "scan/io/project/view_spec.h"
#include "scan/io/workspaces/rgbd/rgbd_folder.h"

namespace relief {

/// Whether a text is a transforms.json as instant-ngp and nerfstudio read it: frames with matrices.
bool looks_like_nerf_transforms(std::string_view text);

/// Whether a folder holds a transforms.json whose frames name depth maps.
bool is_nerf_folder(const std::filesystem::path& folder);

/// Parses a transforms.json: a view in metres for each frame whose depth map (`depth_file_path`, or
/// `depth_path`) is there; file names are relative to `path`. `transform_matrix` is world_from_view
/// of a camera with x right, y up, z back, times any number; a guess. Intrinsics: the options, else
/// `fl_x fl_y cx cy w h`, or `camera_angle_x`, of the frame or of all, with the centre of the first
/// pixel at (0.5, 0.5) and scaled to the depth map. Depth scale: the options, else
/// `integer_depth_scale`, else nerfstudio's 0.001. `file_path` gives colours where the sizes agree,
/// `mask_path` a mask. Notes tell what is left out or assumed. kBadInput names the place.
Result<ProjectSpec> parse_nerf_transforms(std::string_view text, const std::filesystem::path& path,
                                          const RgbdOptions& options = {});

}  // namespace relief
