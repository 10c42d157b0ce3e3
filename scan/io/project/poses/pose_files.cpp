#include "scan/io/project/poses/pose_files.h"

#include <cstddef>
#include <sstream>
#include <string>

#include <Eigen/Geometry>

#include "scan/io/files/atomic_file.h"
#include "scan/io/files/file_ending.h"
#include "scan/io/files/io_error.h"
#include "scan/io/files/real_path.h"
#include "scan/io/files/text_lines.h"
#include "scan/io/project/view_spec.h"
#include "scan/io/workspaces/workspace_writers.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// Every double is read back as it was.
std::ostringstream exact_text() {
  std::ostringstream text;
  text.precision(17);
  return text;
}

void put_rows(const RigidMotion& motion, std::ostream& text) {
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) text << motion.matrix()(r, c) << (c < 3 ? ' ' : '\n');
}

void put_quaternion(const Eigen::Quaterniond& q, std::ostream& text) {
  text << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w() << '\n';
}

void put_translation(const RigidMotion& motion, std::ostream& text) {
  const Eigen::Vector3d t = motion.translation();
  text << t.x() << ' ' << t.y() << ' ' << t.z() << ' ';
}

std::string open3d_log(const ScanProject& project) {
  auto text = exact_text();
  for (std::size_t i = 0; i < project.views.size(); ++i) {
    text << i << ' ' << i << ' ' << i + 1 << '\n';
    put_rows(project.views[i].world_from_view, text);
  }
  return text.str();
}

std::string tum_trajectory(const ScanProject& project) {
  auto text = exact_text();
  text << "# time tx ty tz qx qy qz qw\n";
  for (std::size_t i = 0; i < project.views.size(); ++i) {
    const RangeView& view = project.views[i];
    double time = 0.0;
    if (parse_number(view.name, time))
      text << view.name;
    else
      text << i;
    text << ' ';
    put_translation(view.world_from_view, text);
    put_quaternion(Eigen::Quaterniond(view.world_from_view.linear()), text);
  }
  return text.str();
}

// The grid file of each view, seen from the folder of `path`.
Result<std::vector<std::string>> grid_files(const ScanProject& project, const fs::path& source,
                                            const ReadProjectOptions& options,
                                            const fs::path& path) {
  const auto spec = read_project_spec(source, options);
  if (!spec) return spec.error();
  const fs::path folder = real_path(path).parent_path();
  std::vector<std::string> files;
  for (const RangeView& view : project.views) {
    for (const ViewSpec& from : spec->views) {
      if (from.name != view.name || !from.grid) continue;
      const fs::path file = real_path(*from.grid);
      const fs::path relative = file.lexically_relative(folder);
      files.push_back((relative.empty() ? file : relative).string());
    }
  }
  if (files.size() == project.views.size()) return files;
  return bad_input(path, "such a file names range grids, and some views of " + source.string() +
                             " are images: first 'relief convert --grids " + source.string() +
                             " -o FOLDER', then convert FOLDER/scan.json");
}

std::string meshlab_aln(const ScanProject& project, const std::vector<std::string>& files) {
  auto text = exact_text();
  text << project.views.size() << '\n';
  for (std::size_t i = 0; i < project.views.size(); ++i) {
    text << files[i] << "\n#\n";
    put_rows(project.views[i].world_from_view, text);
  }
  text << "0\n";
  return text.str();
}

// The quaternion of this format is the inverse of the usual one, as parse_stanford_conf() has it.
std::string stanford_conf(const ScanProject& project, const std::vector<std::string>& files) {
  auto text = exact_text();
  for (std::size_t i = 0; i < project.views.size(); ++i) {
    const RigidMotion& motion = project.views[i].world_from_view;
    text << "bmesh " << files[i] << ' ';
    put_translation(motion, text);
    put_quaternion(Eigen::Quaterniond(motion.linear()).conjugate(), text);
  }
  return text.str();
}

}  // namespace

bool is_pose_path(const fs::path& path) {
  const std::string ending = lower_ending(path);
  return names_grid_files(path) || ending == ".log" || ending == ".tum";
}

bool names_grid_files(const fs::path& path) {
  const std::string ending = lower_ending(path);
  return ending == ".aln" || ending == ".conf" || ending == ".mlp";
}

Result<void> check_pose_file(const ScanProject& project, const fs::path& source,
                             const ReadProjectOptions& source_options, const fs::path& path) {
  if (!names_grid_files(path)) return {};
  const auto files = grid_files(project, source, source_options, path);
  return files ? Result<void>() : files.error();
}

Result<void> write_pose_file(const ScanProject& project, const fs::path& source,
                             const ReadProjectOptions& source_options, const fs::path& path) {
  const std::string ending = lower_ending(path);
  if (ending == ".log") return write_file(path, open3d_log(project));
  if (ending == ".tum") return write_file(path, tum_trajectory(project));
  const auto files = grid_files(project, source, source_options, path);
  if (!files) return files.error();
  if (ending == ".mlp") return write_file(path, meshlab_mlp_text(project.views, *files));
  const bool aln = ending == ".aln";
  return write_file(path, aln ? meshlab_aln(project, *files) : stanford_conf(project, *files));
}

}  // namespace relief
