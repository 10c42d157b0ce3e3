#include <cmath>
#include <sstream>

#include <Eigen/Geometry>

#include "scan/io/clouds/files/point_cloud_file.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/text_lines.h"
#include "scan/io/files/unit_quaternion.h"
#include "scan/io/project/view_spec.h"

namespace relief {

namespace {

// The name of a file may hold blanks: it goes up to the first word with the ending of a scan, else
// it is the first word.
std::string take_file_name(std::istringstream& line) {
  const auto start = line.tellg();
  std::string file;
  for (std::string word; line >> word;) {
    file += (file.empty() ? "" : " ") + word;
    if (has_cloud_ending(file)) return file;
  }
  line.clear();
  line.seekg(start);
  line >> file;
  return file;
}

// `bmesh FILE tx ty tz qx qy qz qw`. The quaternion of this format is the inverse of the usual one:
// p_world = R(q)^T p + t, as the published Stanford scans show.
Result<ViewSpec> parse_bmesh(std::istringstream& line, const std::filesystem::path& path,
                             const std::string& place) {
  const std::string file = take_file_name(line);
  Eigen::Vector3d t;
  double x = 0, y = 0, z = 0, w = 0;
  if (!(line >> t.x() >> t.y() >> t.z() >> x >> y >> z >> w))
    return bad_input(path, place + "expected 'bmesh FILE tx ty tz qx qy qz qw'");
  if (std::string extra; line >> extra)
    return bad_input(path, place + "unexpected '" + extra + "' after the quaternion");
  const Eigen::Quaterniond q(w, x, y, z);
  if (!t.allFinite() || !(std::abs(q.norm() - 1.0) <= kRoundedQuaternion))
    return bad_input(path, place + "the quaternion of " + file + " has length " +
                               std::to_string(q.norm()) + " instead of 1");
  ViewSpec view;
  view.name = std::filesystem::path(file).stem().string();
  view.grid = path.parent_path() / file;
  view.world_from_view.linear() = q.normalized().toRotationMatrix().transpose();
  view.world_from_view.translation() = t;
  view.pose = PoseKind::kGuess;
  return view;
}

}  // namespace

Result<ProjectSpec> parse_stanford_conf(const std::string& text,
                                        const std::filesystem::path& path) {
  ProjectSpec project;
  std::string_view rest = without_byte_order_mark(text);
  for (int number = 1; !rest.empty(); ++number) {
    const std::string place = "line " + std::to_string(number) + ": ";
    std::istringstream words{std::string(next_line(rest))};
    std::string keyword;
    if (!(words >> keyword) || keyword.front() == '#' || keyword == "camera" || keyword == "mesh")
      continue;
    if (keyword != "bmesh")
      return bad_input(path, place + "unknown keyword '" + keyword + "'; expected bmesh or camera");
    auto view = parse_bmesh(words, path, place);
    if (!view) return view.error();
    for (const auto& other : project.views)
      if (other.name == view->name)
        return bad_input(path, place + "a second scan is named " + view->name);
    project.views.push_back(std::move(*view));
  }
  if (project.views.empty()) return bad_input(path, "no bmesh line, so no scan");
  return project;
}

}  // namespace relief
