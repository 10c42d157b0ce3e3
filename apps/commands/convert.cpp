#include <algorithm>
#include <cctype>
#include <memory>
#include <string>

#include "apps/commands/command.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/options/input_kind.h"
#include "relief/io/mesh_io.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/grids/pcd_grid_writer.h"
#include "scan/io/project/pose_files.h"

namespace relief {

namespace {

struct ConvertCommand {
  CommonOptions common;
  ProjectInput input;
  std::filesystem::path output;
  WriteProjectOptions project;
  bool pcd = false;
};

TriangleMesh concatenate(const ScanProject& project) {
  TriangleMesh all;
  const bool all_have_normals =
      std::all_of(project.views.begin(), project.views.end(),
                  [](const RangeView& view) { return view.has_normals(); });
  const bool all_have_colours =
      std::all_of(project.views.begin(), project.views.end(),
                  [](const RangeView& view) { return !view.colours.empty(); });
  for (const RangeView& view : project.views) {
    const TriangleMesh mesh = mesh_from_view(view);
    const auto offset = static_cast<std::uint32_t>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    if (all_have_normals)
      all.normals.insert(all.normals.end(), mesh.normals.begin(), mesh.normals.end());
    if (all_have_colours)
      all.colours.insert(all.colours.end(), mesh.colours.begin(), mesh.colours.end());
    for (const auto& face : mesh.faces)
      all.faces.push_back({face[0] + offset, face[1] + offset, face[2] + offset});
  }
  return all;
}

int convert_mesh(const ConvertCommand& command) {
  const auto mesh = read_mesh(command.input.path);
  if (!mesh) return fail(mesh.error());
  if (const auto written = write_mesh(*mesh, command.output); !written)
    return fail(written.error());
  Console::info(command.output.string() + ": " + std::to_string(mesh->vertices.size()) +
                " vertices, " + std::to_string(mesh->faces.size()) + " faces");
  return kDone;
}

Result<void> write_pcd(const ScanProject& project, const std::filesystem::path& path) {
  if (project.views.size() == 1) return write_file(path, encode_pcd_grid(project.views[0]));
  return Error{ErrorKind::kBadInput, path.string() + ": a PCD file holds one view, the project " +
                                         std::to_string(project.views.size()) +
                                         "; name a folder and give --pcd"};
}

// A name with an ending that no format has is a mistake more often than a folder.
Result<void> check_folder_name(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  const bool looks_like_file =
      ending.size() >= 3 && ending.size() <= 6 &&
      std::all_of(ending.begin() + 1, ending.end(),
                  [](unsigned char letter) { return std::isalpha(letter) != 0; });
  std::error_code code;
  if (!looks_like_file || std::filesystem::is_directory(path, code)) return {};
  return Error{
      ErrorKind::kBadInput,
      path.string() + ": unknown ending '" + ending +
          "'; name a folder, a mesh (.ply .obj .stl .vtp .glb), a .pcd, or a file of poses "
          "(.aln .conf .log .tum)"};
}

Result<void> write_as(const ScanProject& project, const ConvertCommand& command) {
  if (is_mesh_path(command.output)) return write_mesh(concatenate(project), command.output);
  if (command.output.extension() == ".pcd") return write_pcd(project, command.output);
  if (is_pose_path(command.output))
    return write_pose_file(project, command.input.path, command.input.options, command.output);
  if (auto folder = check_folder_name(command.output); !folder) return folder;
  WriteProjectOptions options = command.project;
  if (command.pcd) options = {.grids = true, .grid_format = GridFormat::kPcd};
  return write_project(project, command.output, console_progress("write"), options);
}

int convert_project(const ConvertCommand& command) {
  const auto project = read_with_notes(command.input, command.common);
  if (!project) return fail(project.error());
  const auto written = write_as(*project, command);
  if (!written) return fail(written.error());
  Console::info("wrote " + command.output.string());
  return kDone;
}

}  // namespace

void add_convert(CLI::App& app, Action& action) {
  auto command = std::make_shared<ConvertCommand>();
  auto* sub = app.add_subcommand("convert", "Convert between project and mesh formats");
  sub->add_option("input", command->input.path,
                  "A mesh (.ply .vtp .obj .stl), or anything that is read as a project")
      ->required();
  sub->add_option("--fc", command->input.options.fc_file,
                  "Intrinsics of grids without a camera: a file with fx fy cx cy");
  sub->add_option("-o,--output", command->output,
                  "A mesh file (.ply .obj .stl .vtp .glb; the views of a project become one mesh), "
                  "one view as .pcd, poses as .aln, .conf, .log or .tum, or a folder for a project")
      ->required();
  sub->add_flag("--grids", command->project.grids,
                "Views of a project as range-grid PLY files, points that other programs read");
  sub->add_flag("--pcd", command->pcd, "Views of a project as organized binary PCD files");
  add_common_options(*sub, command->common);
  sub->callback([command, &action] {
    action = [command] {
      return is_triangle_mesh_file(command->input.path) ? convert_mesh(*command)
                                                        : convert_project(*command);
    };
  });
}

}  // namespace relief
