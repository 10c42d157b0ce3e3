#include "scan/io/workspaces/meshlab_mlp.h"

#include <algorithm>
#include <cstddef>
#include <set>
#include <string_view>
#include <vector>

#include <pugixml.hpp>

#include "scan/io/workspaces/workspace_text.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

// A document and its text, for the lines of errors.
struct MlpSource {
  const std::string& text;
  const fs::path& path;

  Error error(std::ptrdiff_t offset, const std::string& what) const {
    const auto end = std::clamp<std::ptrdiff_t>(offset, 0, std::ssize(text));
    const auto line = std::count(text.begin(), text.begin() + end, '\n') + 1;
    return bad_input(path, "line " + std::to_string(line) + ": " + what);
  }
};

// Sixteen numbers, and no more.
bool take_sixteen(std::string_view text, double* numbers) {
  std::size_t count = 0;
  while (!text.empty()) {
    for (std::string_view line = next_line(text); count < 17;) {
      double number = 0.0;
      const std::string_view word = next_word(line);
      if (word.empty()) break;
      if (!parse_number(word, number)) return count == 16;
      if (count < 16) numbers[count] = number;
      ++count;
    }
  }
  return count == 16;
}

// A matrix with a scale, which MeshLab's glueing allows, is no pose: it is left out with a note.
Result<void> take_mlp_pose(const MlpSource& source, const pugi::xml_node& mesh, ViewSpec& view,
                           std::vector<std::string>& notes) {
  const pugi::xml_node node = mesh.child("MLMatrix44");
  if (!node) return {};
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> matrix;
  if (!take_sixteen(node.child_value(), matrix.data()))
    return source.error(node.offset_debug(), "expected sixteen numbers in the MLMatrix44 of " +
                                                 view.name + "; save the project again as .mlp");
  const auto motion = rigid_motion_from_matrix(matrix, "the matrix of " + view.name);
  if (!motion) {
    notes.push_back("view " + view.name + ": taken without a pose: " +
                    source.error(node.offset_debug(), motion.error().message).message);
    return {};
  }
  view.world_from_view = *motion;
  view.pose = PoseKind::kGuess;
  return {};
}

Result<ViewSpec> view_of_mesh(const MlpSource& source, const pugi::xml_node& mesh,
                              const std::set<std::string>& names, std::vector<std::string>& notes) {
  const std::string file = mesh.attribute("filename").value();
  if (file.empty())
    return source.error(mesh.offset_debug(),
                        "an MLMesh has no filename; save its mesh to a file, then the project");
  ViewSpec view;
  view.grid = source.path.parent_path() / file;
  view.name = view.grid->stem().string();
  if (names.contains(view.name)) view.name = view.grid->filename().string();
  if (names.contains(view.name))
    return source.error(mesh.offset_debug(), "a second mesh is named " + view.name);
  if (auto taken = take_mlp_pose(source, mesh, view, notes); !taken) return taken.error();
  return view;
}

}  // namespace

Result<ProjectSpec> parse_meshlab_mlp(const std::string& text, const fs::path& path) {
  const MlpSource source{text, path};
  pugi::xml_document document;
  const auto parsed = document.load_buffer(text.data(), text.size());
  if (!parsed)
    return source.error(parsed.offset, std::string("not valid XML: ") + parsed.description());
  const pugi::xml_node root = document.child("MeshLabProject");
  if (!root) return bad_input(path, "no MeshLabProject in it, so no project of MeshLab");
  ProjectSpec project;
  project.unit = "units";
  std::set<std::string> names;
  for (const auto& group : root.children("MeshGroup"))
    for (const auto& mesh : group.children("MLMesh")) {
      auto view = view_of_mesh(source, mesh, names, project.notes);
      if (!view) return view.error();
      names.insert(view->name);
      project.views.push_back(std::move(*view));
    }
  if (project.views.empty()) return bad_input(path, "no MLMesh in it, so no scan");
  if (root.child("RasterGroup").child("MLRaster"))
    project.notes.push_back(path.string() + ": raster layers are not read");
  return project;
}

}  // namespace relief
