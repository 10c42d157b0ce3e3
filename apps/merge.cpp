#include <memory>

#include "apps/command.h"
#include "apps/console.h"
#include "apps/exit_status.h"
#include "apps/output.h"
#include "apps/stage_options.h"
#include "apps/stages.h"
#include "scan/io/mesh_io.h"

namespace relief {

namespace {

struct MergeCommand {
  CommonOptions common;
  ProjectInput input;
  MergeFlags merge;
  std::filesystem::path output;
};

int merge(const MergeCommand& command) {
  const auto project = read_with_notes(command.input, command.common);
  if (!project) return fail(project.error());
  if (const auto ready = prepare_folder_of(command.output); !ready) return fail(ready.error());
  MergeStageOptions options = command.merge.resolved();
  options.threads = command.common.threads;
  const auto stage = merge_stage(*project, options);
  if (!stage) return fail(stage.error());

  if (const auto written = write_mesh(stage->mesh, command.output); !written)
    return fail(written.error());
  const auto reported = write_report(report_path(command.common, command.output), "merge",
                                     stage->report, command.common);
  if (!reported) return fail(reported.error());
  Console::info("wrote " + command.output.string());
  return kDone;
}

}  // namespace

void add_merge(CLI::App& app, Action& action) {
  auto command = std::make_shared<MergeCommand>();
  auto* sub = app.add_subcommand("merge", "Merge aligned views to one watertight mesh");
  add_project_input(*sub, command->input);
  sub->add_option("-o,--output", command->output,
                  "Mesh file; its ending (.ply .obj .stl .vtp .glb) is its format")
      ->required()
      ->check(known_mesh_ending());
  add_merge_options(*sub, command->merge);
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return merge(*command); }; });
}

}  // namespace relief
