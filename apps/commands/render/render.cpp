#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "apps/commands/command.h"
#include "apps/commands/outputs.h"
#include "apps/commands/render/render_cells.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/output.h"
#include "apps/console/picture_file.h"
#include "apps/console/progress_display.h"
#include "apps/options/input_kind.h"
#include "apps/options/render_flags.h"
#include "apps/reports/report.h"
#include "scan/io/files/file_ending.h"

namespace relief {

namespace {

struct RenderCommand {
  CommonOptions common;
  std::vector<std::filesystem::path> inputs;
  ReadProjectOptions reading;
  std::filesystem::path output;
  RenderFlags flags;
};

Json cell_report(const RenderCell& cell) {
  Json json = {{"caption", cell.caption},
               {"width", cell.picture.width()},
               {"height", cell.picture.height()}};
  if (!cell.legend) return json;
  json["title"] = cell.legend->title;
  if (!cell.legend->bar.empty()) json["range"] = {cell.legend->low, cell.legend->high};
  return json;
}

// Writes one picture, says so, and adds it to the report.
Result<void> write_sheet(const RenderSheet& sheet, const RenderFlags& flags,
                         const std::filesystem::path& file, Json& report) {
  const rendering::Picture picture = compose(sheet, flags);
  auto written = write_picture(picture, flags.options.background, describe(sheet), file);
  if (!written) return written;
  Console::info(
      fmt::format("wrote {}: {} x {} pixels", file.string(), picture.width(), picture.height()));
  Json cells = Json::array();
  for (const RenderCell& cell : sheet.cells) cells.push_back(cell_report(cell));
  report["pictures"].push_back({{"file", file.string()}, {"cells", cells}});
  return {};
}

std::string name_of(const rendering::ViewingDirection& direction) {
  return fmt::format("view {:g},{:g}", direction.azimuth_deg, direction.elevation_deg);
}

std::filesystem::path frame_file(const std::filesystem::path& output, int frame) {
  std::filesystem::path file = output;
  file.replace_filename(
      fmt::format("{}-{:03}{}", output.stem().string(), frame, output.extension().string()));
  return file;
}

Result<void> render_turntable(const RenderCommand& command, const std::vector<RenderModel>& models,
                              Json& report) {
  const RenderFlags& flags = command.flags;
  if (flags.directions.size() > 1)
    return Error{ErrorKind::kBadInput, "--turntable starts at one --view, not at several"};
  const auto first =
      flags.directions.empty() ? rendering::ViewingDirection() : flags.directions.front();
  const auto directions = rendering::turntable_directions(first, flags.turntable);
  const auto cameras = frame_series(models.front().scene.mesh(), directions, flags.framing);
  const Progress progress = console_progress("render");
  for (int i = 0; i < flags.turntable; ++i) {
    const auto frame = static_cast<std::size_t>(i);
    if (!report_progress(progress, static_cast<double>(i) / flags.turntable, "turntable"))
      return Error{ErrorKind::kInterrupted, "rendering stopped"};
    const auto sheet = model_sheet(models, {cameras[frame]}, {""}, flags, {});
    if (!sheet) return sheet.error();
    if (auto done = write_sheet(*sheet, flags, frame_file(command.output, i), report); !done)
      return done;
  }
  return {};
}

Result<void> render_models(const RenderCommand& command, Json& report) {
  const RenderFlags& flags = command.flags;
  if (!flags.only.empty())
    return Error{ErrorKind::kBadInput, "--only names views of a project, but " +
                                           command.inputs.front().string() + " is a mesh"};
  if (!flags.truth.empty() && !flags.shows(rendering::RenderStyle::kDistance))
    return Error{ErrorKind::kBadInput, "--truth is for the style distance: add --style distance"};
  const auto models = read_models(command.inputs, flags);
  if (!models) return models.error();
  if (flags.turntable > 0) return render_turntable(command, *models, report);
  std::vector<rendering::ViewingDirection> directions = flags.directions;
  if (directions.empty() && flags.contact_sheet) directions = rendering::six_sides();
  if (directions.empty()) directions.emplace_back();
  std::vector<rendering::PictureCamera> cameras;
  std::vector<std::string> names;
  for (const auto& direction : directions) {
    cameras.push_back(frame_mesh(models->front().scene.mesh(), direction, flags.framing));
    names.push_back(directions.size() > 1 ? name_of(direction) : "");
  }
  const auto sheet = model_sheet(*models, cameras, names, flags, console_progress("render"));
  if (!sheet) return sheet.error();
  return write_sheet(*sheet, flags, command.output, report);
}

// Flags that have no meaning for the cameras of views.
Result<void> check_for_views(const RenderFlags& flags) {
  const rendering::FramingOptions own;
  const bool other_angle = flags.framing.field_of_view_deg != own.field_of_view_deg;
  const char* wrong = !flags.directions.empty()    ? "--view"
                      : flags.turntable > 0        ? "--turntable"
                      : !flags.truth.empty()       ? "--truth"
                      : flags.framing.up != own.up ? "--up"
                      : other_angle                ? "--field-of-view"
                                                   : nullptr;
  if (!wrong) return {};
  return Error{ErrorKind::kBadInput,
               std::string(wrong) + " is for models; views are shown from their own cameras"};
}

Result<void> render_projects(const RenderCommand& command, Json& report) {
  if (auto checked = check_for_views(command.flags); !checked) return checked;
  std::vector<RenderProject> projects;
  for (const auto& path : command.inputs) {
    const ProjectInput input{path, command.reading};
    if (auto free = check_outputs(input, {{}, {command.output}}); !free) return free.error();
    auto project = read_with_notes(input, command.common);
    if (!project) return project.error();
    projects.push_back({path, *std::move(project)});
  }
  const auto sheet = view_sheet(projects, command.flags, console_progress("render"));
  if (!sheet) return sheet.error();
  return write_sheet(*sheet, command.flags, command.output, report);
}

// Single pictures of a sheet are smaller.
void choose_size(RenderFlags& flags, std::size_t inputs, bool models) {
  const bool sheet = !models || inputs > 1 || flags.styles.size() > 1 ||
                     flags.directions.size() > 1 || flags.contact_sheet;
  if (flags.has_size || !sheet) return;
  flags.framing.width = 512;
  flags.framing.height = 384;
}

Result<void> render_all(RenderCommand& command, Json& report) {
  if (lower_ending(command.output) != ".png")
    return Error{ErrorKind::kBadInput,
                 command.output.string() + ": pictures are written as PNG; end the name in .png"};
  if (auto ready = prepare_folder_of(command.output); !ready) return ready;
  const auto meshes = std::count_if(command.inputs.begin(), command.inputs.end(),
                                    [](const auto& path) { return is_triangle_mesh_file(path); });
  if (meshes != 0 && meshes != static_cast<std::ptrdiff_t>(command.inputs.size()))
    return Error{ErrorKind::kBadInput,
                 "meshes and projects are not shown in one picture: give inputs of one kind"};
  choose_size(command.flags, command.inputs.size(), meshes != 0);
  command.flags.options.seed = command.common.seed;
  return meshes != 0 ? render_models(command, report) : render_projects(command, report);
}

int render(RenderCommand& command) {
  Json report = {{"pictures", Json::array()}};
  if (const auto done = render_all(command, report); !done) return fail(done.error());
  const auto delivered = report_on_request("render", report, command.common);
  return delivered ? kDone : fail(delivered.error());
}

}  // namespace

void add_render(CLI::App& app, Action& action) {
  auto command = std::make_shared<RenderCommand>();
  auto* sub = app.add_subcommand("render", "Pictures of models and of views, without a display");
  sub->add_option("input", command->inputs,
                  "Models (.ply .vtp .obj .stl), or anything that is read as a project; several of "
                  "one kind: side by side")
      ->required();
  sub->add_option("-o,--output", command->output, "A file .png")->required();
  add_render_flags(*sub, command->flags);
  add_reading_options(*sub, command->reading);
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return render(*command); }; });
}

}  // namespace relief
