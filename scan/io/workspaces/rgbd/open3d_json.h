#pragma once

#include <string_view>

namespace relief {

/// Whether a JSON text looks like a camera of Open3D (with `intrinsic_matrix`), or like a
/// trajectory (with `extrinsic` too). It is not parsed.
bool looks_like_open3d_camera(std::string_view text);
bool looks_like_open3d_trajectory(std::string_view text);

}  // namespace relief
