#include <memory>
#include <string>
#include <utility>

#include "apps/commands/command.h"
#include "apps/commands/merge/merge_within_limit.h"
#include "apps/commands/outputs.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/output.h"
#include "apps/console/progress_display.h"
#include "apps/options/memory_option.h"
#include "apps/options/stage_options.h"
#include "apps/reports/stages/model_report.h"
#include "relief/io/mesh_io.h"
#include "relief/reconstruction/build_model.h"
#include "scan/base/memory/memory_limit.h"
#include "scan/base/stopwatch.h"

namespace relief {

namespace {

struct MergeCommand {
  CommonOptions common;
  ProjectInput input;
  MergeFlags merge;
  MemoryFlag memory;
  std::filesystem::path output;
};

struct MergedProject {
  reconstruction::Model model;
  std::string unit;
  double seconds = 0.0;  // Without the reading of views that are held in memory.
};

Result<MergedProject> in_memory(const MergeCommand& command,
                                const reconstruction::ModelOptions& options,
                                const Context& context) {
  const auto project = read_with_notes(command.input, command.common);
  if (!project) return project.error();
  if (const auto ready = prepare_folder_of(command.output); !ready) return ready.error();
  const Stopwatch watch;
  auto model =
      reconstruction::build_model(project->views, options, context, console_stage_progress());
  if (!model) return model.error();
  return MergedProject{std::move(*model), project->unit, watch.seconds()};
}

Result<MergedProject> within_limit(const MergeCommand& command,
                                   const reconstruction::ModelOptions& options,
                                   const Context& context) {
  if (const auto ready = prepare_folder_of(command.output); !ready) return ready.error();
  const Stopwatch watch;
  MergedProject merged;
  auto model = merge_within_limit(command.input, options, context, merged.unit);
  if (!model) return model.error();
  merged.model = std::move(*model);
  merged.seconds = watch.seconds();
  return merged;
}

int merge(const MergeCommand& command) {
  const std::filesystem::path report_file = report_path(command.common, command.output);
  if (const auto free = check_outputs(command.input, {{}, {command.output, report_file}}); !free)
    return fail(free.error());
  const reconstruction::ModelOptions options = command.merge.resolved();
  // Stages tell their progress themselves.
  const Context context = context_of(command.common, "").with_progress({});
  const auto merged = current_memory_limit() ? within_limit(command, options, context)
                                             : in_memory(command, options, context);
  if (!merged) return fail(merged.error());
  Json report = to_json(merged->model);
  report["seconds"] = merged->seconds;
  report["peak_memory_mb"] = peak_memory_mb();
  log_model(merged->model, merged->unit, report["seconds"]);

  if (const auto written = write_mesh(merged->model.mesh, command.output); !written)
    return fail(written.error());
  const auto reported = write_report(report_file, "merge", report, command.common);
  if (!reported) return fail(reported.error());
  Console::info("wrote " + command.output.string());
  return kDone;
}

}  // namespace

void add_merge(CLI::App& app, Action& action) {
  auto command = std::make_shared<MergeCommand>();
  auto* sub = app.add_subcommand("merge", "Merge aligned views to one watertight mesh");
  add_project_input(*sub, command->input);
  add_background_option(*sub, command->input);
  sub->add_option("-o,--output", command->output,
                  "Mesh file; its ending (.ply .obj .stl .vtp .glb .3mf) is its format")
      ->required()
      ->check(known_mesh_ending());
  add_merge_options(*sub, command->merge);
  add_memory_option(*sub, command->memory,
                    "views are read one at a time, large fields lie in temporary files beside the "
                    "output");
  add_common_options(*sub, command->common);
  sub->callback([command, &action] {
    action = [command] {
      return work_within(command->memory, command->output.parent_path(),
                         [&] { return merge(*command); });
    };
  });
}

}  // namespace relief
