#include <algorithm>
#include <cctype>
#include <memory>
#include <string>

#include "apps/commands/command.h"
#include "apps/commands/convert/export_tiles.h"
#include "apps/commands/convert/export_views.h"
#include "apps/commands/outputs.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/options/input_kind.h"
#include "apps/options/memory_option.h"
#include "relief/io/mesh_io.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/io/workspaces/workspace_writers.h"

namespace relief {

namespace {

struct ConvertCommand {
  CommonOptions common;
  ProjectInput input;
  std::filesystem::path output;
  WriteProjectOptions project;
  std::string unit = "mm";
  MemoryFlag memory;
  bool pcd = false, colmap = false, xf = false, as_views = false;
};

int convert_mesh(const ConvertCommand& command) {
  const bool tiles = is_tileset_path(command.output);
  if (!tiles && !is_mesh_path(command.output))
    return fail({ErrorKind::kBadInput,
                 command.output.string() + ": " + command.input.path.string() +
                     " is a mesh, which is written as .ply, .obj, .stl, .vtp, .glb or .3mf, or "
                     "in tiles as .json; --as-views takes it as points that a scanner saw"});
  if (const auto free = check_output(command.input.path, command.output); !free)
    return fail(free.error());
  const auto mesh = read_mesh(command.input.path);
  if (!mesh) return fail(mesh.error());
  const auto written =
      tiles ? export_tiles(*mesh, command.unit, command.output, context_of(command.common, "write"))
            : write_mesh(*mesh, command.output);
  if (!written) return fail(written.error());
  Console::info(command.output.string() + ": " + std::to_string(mesh->vertices.size()) +
                " vertices, " + std::to_string(mesh->faces.size()) + " faces");
  return kDone;
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
  return Error{ErrorKind::kBadInput, path.string() + ": unknown ending '" + ending +
                                         "'; name a folder, a mesh (.ply .obj .stl .vtp .glb "
                                         ".3mf), views (.e57 .ptx .pcd), or a file "
                                         "of poses (.aln .conf .mlp .log .tum)"};
}

Result<void> write_as(const ScanProject& project, const ConvertCommand& command) {
  if (command.colmap) return write_colmap_text(project.views, command.output);
  if (command.xf) return write_xf_folder(project.views, command.output);
  if (is_export_path(command.output))
    return export_views(project, command.input.path, command.input.options, command.output);
  if (is_tileset_path(command.output))
    return Error{ErrorKind::kBadInput,
                 command.output.string() +
                     ": tiles are cut from a mesh; merge the views, then convert the model"};
  if (auto folder = check_folder_name(command.output); !folder) return folder;
  WriteProjectOptions options = command.project;
  if (command.pcd) options = {.grids = true, .grid_format = GridFormat::kPcd};
  return write_project(project, command.output, context_of(command.common, "write"), options);
}

// Poses alone go into files that no project is read from.
Outputs outputs_of(const ConvertCommand& command) {
  if (command.colmap || command.xf) return {};
  if (is_export_path(command.output)) return {.files = {command.output}};
  return {.folder = command.output};
}

int convert_project(const ConvertCommand& command) {
  if (const auto free = check_outputs(command.input, outputs_of(command)); !free)
    return fail(free.error());
  const auto project = read_with_notes(command.input, command.common);
  if (!project) return fail(project.error());
  const auto written = write_as(*project, command);
  if (!written) return fail(written.error());
  Console::info("wrote " + command.output.string());
  return kDone;
}

int convert(const ConvertCommand& command) {
  const bool mesh = is_triangle_mesh_file(command.input.path) && !command.as_views;
  return mesh ? convert_mesh(command) : convert_project(command);
}

}  // namespace

void add_convert(CLI::App& app, Action& action) {
  auto command = std::make_shared<ConvertCommand>();
  auto* sub = app.add_subcommand("convert", "Convert between project and mesh formats");
  sub->add_option("input", command->input.path,
                  "A mesh (.ply .vtp .obj .stl), or anything that is read as a project")
      ->required();
  sub->add_flag("--as-views", command->as_views, "Read a mesh as points that a scanner saw");
  add_reading_options(*sub, command->input.options);
  sub->add_option(
         "-o,--output", command->output,
         "A mesh file (.ply .obj .stl .vtp .glb .3mf; the views of a project become one mesh), "
         "views as .e57 or .ptx, one view as .pcd, poses as .aln, .conf, .mlp, .log or "
         ".tum, a folder for a project, or a mesh in tiles of several levels of "
         "detail (3D Tiles) as .json")
      ->required();
  sub->add_option("--unit", command->unit, "Unit of a mesh that is written in tiles")
      ->capture_default_str();
  sub->add_flag("--grids", command->project.grids,
                "Views of a project as range-grid PLY files, points that other programs read");
  sub->add_flag("--pcd", command->pcd, "Views of a project as organized binary PCD files");
  sub->add_flag("--colmap", command->colmap,
                "The cameras and poses as the text files of a COLMAP model, into the folder");
  sub->add_flag("--xf", command->xf, "The poses as one .xf file a view, into the folder");
  add_memory_option(*sub, command->memory, "large meshes lie in temporary files beside the output");
  add_common_options(*sub, command->common);
  sub->callback([command, &action] {
    action = [command] {
      return work_within(command->memory, command->output.parent_path(),
                         [&] { return convert(*command); });
    };
  });
}

}  // namespace relief
