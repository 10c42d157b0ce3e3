#include <string>
#include <string_view>

#include "scan/io/files/io_error.h"
#include "scan/io/files/text_lines.h"
#include "scan/io/project/view_spec.h"

namespace relief {

namespace {

// The lines of an alignment file, with their numbers for errors. Blank lines are skipped.
class AlnLines {
 public:
  AlnLines(std::string_view text, const std::filesystem::path& path)
      : text_(without_byte_order_mark(text)), path_(path) {}

  /// The next line without blanks at its ends; an error at the end of the file.
  Result<std::string_view> next(const char* expected) {
    while (!text_.empty()) {
      std::string_view line = next_line(text_);
      ++number_;
      while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
      while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
      if (!line.empty()) return line;
    }
    return bad_input(path_, std::string("the file ends where ") + expected + " should be");
  }

  Error error(const std::string& what) const {
    return bad_input(path_, "line " + std::to_string(number_) + ": " + what);
  }

 private:
  std::string_view text_;
  const std::filesystem::path& path_;
  int number_ = 0;
};

Result<RigidMotion> read_motion(AlnLines& lines, const std::string& name) {
  Eigen::Matrix4d matrix;
  for (int r = 0; r < 4; ++r) {
    auto line = lines.next("a row of four numbers");
    if (!line) return line.error();
    for (int c = 0; c < 4; ++c)
      if (!parse_number(next_word(*line), matrix(r, c)))
        return lines.error("expected a row of four numbers of the matrix of " + name);
  }
  auto motion = rigid_motion_from_matrix(matrix, "the matrix of " + name);
  if (!motion) return lines.error(motion.error().message);
  return motion;
}

Result<ViewSpec> read_view(AlnLines& lines, std::string_view file,
                           const std::filesystem::path& path) {
  ViewSpec view;
  view.grid = path.parent_path() / std::filesystem::path(std::string(file));
  view.name = view.grid->stem().string();
  const auto separator = lines.next("a line #");
  if (!separator) return separator.error();
  if (*separator != "#") return lines.error("expected a line with # after the name of a file");
  const auto motion = read_motion(lines, view.name);
  if (!motion) return motion.error();
  view.world_from_view = *motion;
  view.pose = PoseKind::kGuess;
  return view;
}

}  // namespace

Result<ProjectSpec> parse_meshlab_aln(const std::string& text, const std::filesystem::path& path) {
  AlnLines lines(text, path);
  auto first = lines.next("the number of meshes");
  if (!first) return first.error();
  double count = 0.0;
  if (!parse_number(next_word(*first), count) || count < 1.0)
    return lines.error("expected the number of meshes");
  ProjectSpec project;
  for (double i = 0.0; i < count; i += 1.0) {
    const auto file = lines.next("the name of a mesh");
    if (!file) return file.error();
    auto view = read_view(lines, *file, path);
    if (!view) return view.error();
    for (const ViewSpec& other : project.views)
      if (other.name == view->name) return lines.error("a second mesh is named " + view->name);
    project.views.push_back(std::move(*view));
  }
  return project;
}

}  // namespace relief
