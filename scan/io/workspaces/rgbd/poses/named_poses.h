#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

/// Poses in a file, and what it says whose they are.
struct PoseList {
  std::vector<std::optional<RigidMotion>> world_from_view;  ///< Nothing where it is lost.
  /// By the field of the file that has them: a text for each pose, which may be the name or the
  /// number of a frame or of its image. Empty where nothing tells.
  std::map<std::string, std::vector<std::string>> names;
  bool is_ordered = true;  ///< Whether the poses may be in the order of the frames.

  bool empty() const { return world_from_view.empty(); }
};

/// The poses of a JSON document: matrices of 4x4 or 3x4 numbers by their keys
/// (`{"000000": [[...]]}`), in objects by their keys or with texts or whole numbers beside them
/// (`[{"name": "000000.png", "pose": [[...]]}]`), or in a list. The list with the most poses is
/// taken, of the document and of what lies one level down. Empty where there is none, and for text
/// that is no JSON. kBadInput names the place of a matrix that is no rigid motion.
Result<PoseList> parse_json_poses(std::string_view text, const std::filesystem::path& path);

/// The poses of a table, one a line. Either each line holds a name and the seven numbers
/// `tx ty tz qx qy qz qw` or the 12 or 16 of a matrix by rows, or a heading names the columns:
/// those seven, in any order (also `x`, `pos_x`, `t_x`; `q_x`, `rot_x`), and others, which may name
/// the frame. Blanks, commas or semicolons stand between. A pose of numbers that are not finite or
/// missing, or with zeros for the rotation, is lost. Empty for other text; kBadInput names the line
/// of a pose that is none.
Result<PoseList> parse_pose_table(std::string_view text, const std::filesystem::path& path);

/// The poses of a NumPy array of floats: one matrix of 4x4 or 3x4 numbers, or many, or rows of 16
/// or 12 numbers, or of `tx ty tz qx qy qz qw`, lost as those of a table. Empty for other arrays,
/// as of seven numbers without a unit quaternion in the first row; kBadInput names the matrix or
/// row that is no rigid motion, a header that is damaged, and a file that ends too soon.
Result<PoseList> parse_npy_poses(std::string_view content, const std::filesystem::path& path);

}  // namespace relief
