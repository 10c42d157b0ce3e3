#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/outputs.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/output.h"
#include "apps/options/memory_option.h"
#include "apps/options/stage_options.h"
#include "apps/reports/stages/refinement_report.h"
#include "relief/hybrid/refine_view.h"
#include "scan/base/stopwatch.h"

namespace relief {

namespace {

struct RefineCommand {
  CommonOptions common;
  ProjectInput input;
  RefineFlags flags;
  MemoryFlag memory;
  std::filesystem::path output;
};

int refine(const RefineCommand& command) {
  const std::filesystem::path report_file =
      report_path(command.common, command.output / "scan.json");
  if (const auto free = check_outputs(command.input, {command.output, {report_file}}); !free)
    return fail(free.error());
  auto project = read_with_notes(command.input, command.common);
  if (!project) return fail(project.error());
  if (const auto ready = prepare_folder(command.output); !ready) return fail(ready.error());
  const Context context = context_of(command.common, "refine");
  const Stopwatch watch;
  auto refined = hybrid::refine_views(project->views, command.flags.resolved(), context);
  if (!refined) return fail(refined.error());
  std::vector<hybrid::RefineSummary> refinements(refined->begin(), refined->end());
  for (std::size_t i = 0; i < refined->size(); ++i)
    project->views[i] = std::move((*refined)[i].view);
  Json report = refinement_report(refinements, project->views);
  report["seconds"] = watch.seconds();
  log_refinement(refinements, project->views, project->unit, report["seconds"]);

  if (const auto written =
          write_project(*project, command.output, context_of(command.common, "write"));
      !written)
    return fail(written.error());
  const auto reported = write_report(report_file, "refine", report, command.common);
  if (!reported) return fail(reported.error());
  Console::info("wrote " + (command.output / "scan.json").string());
  const bool failed = std::any_of(refinements.begin(), refinements.end(),
                                  [](const auto& view) { return view.failed(); });
  return failed ? kDataDoesNotAllow : kDone;
}

}  // namespace

void add_refine(CLI::App& app, Action& action) {
  auto command = std::make_shared<RefineCommand>();
  auto* sub = app.add_subcommand(
      "refine", "Solve each view for the surface that agrees with its positions and normals");
  add_project_input(*sub, command->input);
  add_background_option(*sub, command->input);
  sub->add_option("-o,--output", command->output, "Folder for the refined project")->required();
  add_refine_options(*sub, command->flags);
  add_memory_option(
      *sub, command->memory,
      "fewer views are refined at once, views that do not fit lie in temporary files in "
      "DIR");
  add_common_options(*sub, command->common);
  sub->callback([command, &action] {
    action = [command] {
      return work_within(command->memory, command->output, [&] { return refine(*command); });
    };
  });
}

}  // namespace relief
