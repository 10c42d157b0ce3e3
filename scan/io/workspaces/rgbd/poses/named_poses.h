#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "relief/scan/result.h"
#include "relief/scan/scan_project.h"

namespace relief {

/// Poses of a file that tells by `name` whose each is: name or number of the frame or its image;
/// empty: by the order.
using NamedPoses = std::vector<NamedPose>;

/// The poses of a JSON document: matrices of 4x4 or 3x4 numbers by their keys
/// (`{"000000": [[...]]}`), in objects by their keys or with a name or number inside
/// (`[{"name": "000000.png", "pose": [[...]]}]`), or in a list in the order of the frames. They may
/// lie one level down. Empty where there are none, and for text that is no JSON. kBadInput names
/// the place of a matrix that is no rigid motion.
Result<NamedPoses> parse_json_poses(std::string_view text, const std::filesystem::path& path);

/// The poses of a table, one a line. Either each line holds a name and the seven numbers
/// `tx ty tz qx qy qz qw` or the 12 or 16 of a matrix by rows, or a heading names the columns:
/// those seven, in any order (also `x`, `pos_x`, `t_x`; `q_x`, `rot_x`), and the first other one,
/// if there is one, for the frame. Blanks, commas or semicolons stand between. Empty for other
/// text; kBadInput names the line of a pose that is none.
Result<NamedPoses> parse_pose_table(std::string_view text, const std::filesystem::path& path);

/// The poses of a NumPy array of floats: one matrix of 4x4 or 3x4 numbers, or many, or rows of 16
/// or 12 numbers, in the order of the frames. Empty for other arrays; kBadInput names the matrix
/// that is no rigid motion, and a file that ends too soon.
Result<NamedPoses> parse_npy_poses(std::string_view content, const std::filesystem::path& path);

}  // namespace relief
