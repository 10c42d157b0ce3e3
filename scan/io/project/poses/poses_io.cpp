#include <nlohmann/json.hpp>

#include "relief/io/project_io.h"
#include "scan/io/files/atomic_file.h"

namespace relief {

namespace {

using nlohmann::json;

Error bad_pose(const std::filesystem::path& path, const std::string& what) {
  return {ErrorKind::kBadInput, path.string() + ": " + what};
}

bool is_number_matrix(const json& rows) {
  if (!rows.is_array() || rows.size() != 4) return false;
  for (const json& row : rows) {
    if (!row.is_array() || row.size() != 4) return false;
    for (const json& entry : row)
      if (!entry.is_number()) return false;
  }
  return true;
}

}  // namespace

Result<std::vector<NamedPose>> read_poses(const std::filesystem::path& path) {
  const auto text = read_file(path);
  if (!text) return text.error();
  json document = json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (document.is_discarded()) return bad_pose(path, "is not JSON; give a file with `views`");
  if (document.is_object() && document.contains("align")) document = document["align"];
  if (!document.is_object() || !document.contains("views") || !document["views"].is_array())
    return bad_pose(path, "has no array `views`");

  std::vector<NamedPose> poses;
  for (const json& view : document["views"]) {
    const std::string place = "views[" + std::to_string(poses.size()) + "]";
    if (!view.is_object() || !view.contains("name") || !view["name"].is_string())
      return bad_pose(path, place + " has no `name`");
    if (!view.contains("world_from_view") || !is_number_matrix(view["world_from_view"]))
      return bad_pose(path, place + ".world_from_view must be 4 rows of 4 numbers");
    Eigen::Matrix4d matrix;
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) matrix(r, c) = view["world_from_view"][r][c].get<double>();
    const auto motion =
        rigid_motion_from_matrix(matrix, path.string() + ": " + place + ".world_from_view");
    if (!motion) return motion.error();
    poses.push_back({view["name"].get<std::string>(), *motion});
  }
  return poses;
}

}  // namespace relief
