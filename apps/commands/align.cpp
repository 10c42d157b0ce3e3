#include <filesystem>
#include <memory>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/convert/export_views.h"
#include "apps/commands/outputs.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/output.h"
#include "apps/options/memory_option.h"
#include "apps/options/stage_options.h"
#include "apps/reports/stages/alignment_report.h"
#include "relief/registration/align_views.h"
#include "scan/base/stopwatch.h"

namespace relief {

namespace {

struct AlignCommand {
  CommonOptions common;
  ProjectInput input;
  registration::AlignOptions options;
  MemoryFlag memory;
  std::filesystem::path output;
  std::vector<std::filesystem::path> exports;
};

Outputs outputs_of(const AlignCommand& command) {
  Outputs outputs{.files = command.exports};
  outputs.files.push_back(command.output);
  outputs.files.push_back(report_path(command.common, command.output));
  return outputs;
}

int align(const AlignCommand& command) {
  if (const auto free = check_outputs(command.input, outputs_of(command)); !free)
    return fail(free.error());
  auto project = read_with_notes(command.input, command.common);
  if (!project) return fail(project.error());
  if (const auto can =
          check_exports(*project, command.input.path, command.input.options, command.exports);
      !can)
    return fail(can.error());
  if (const auto ready = prepare_folder_of(command.output); !ready) return fail(ready.error());
  registration::AlignOptions options = command.options;
  const Stopwatch watch;
  const auto alignment =
      registration::align_views(project->views, options, context_of(command.common, "align"));
  if (!alignment) return fail(alignment.error());
  registration::apply_alignment(*alignment, project->views);
  Json report = to_json(*alignment);
  report["seconds"] = watch.seconds();
  log_alignment(*alignment, project->unit, report["seconds"]);
  warn_of_unverified(*alignment);

  const auto written =
      write_project_poses(*project, command.input.path, command.input.options, command.output);
  if (!written) return fail(written.error());
  if (auto done = export_all(*project, command.input.path, command.input.options, command.exports);
      !done)
    return fail(done.error());
  const auto reported =
      write_report(report_path(command.common, command.output), "align", report, command.common);
  if (!reported) return fail(reported.error());
  Console::info("wrote " + command.output.string());
  return alignment->complete() && alignment->solved() ? kDone : kDataDoesNotAllow;
}

}  // namespace

void add_align(CLI::App& app, Action& action) {
  auto command = std::make_shared<AlignCommand>();
  auto* sub = app.add_subcommand("align", "Find the poses of all views");
  add_project_input(*sub, command->input);
  command->input.options.for_alignment = true;
  add_background_option(*sub, command->input);
  sub->add_option("-o,--output", command->output,
                  "A scan.json with the poses found; it refers to the data of the input")
      ->required();
  add_export_option(*sub, command->exports);
  add_align_options(*sub, command->options);
  add_common_options(*sub, command->common);
  add_memory_option(*sub, command->memory,
                    "views that do not fit lie in temporary files beside the output");
  sub->callback([command, &action] {
    action = [command] {
      return work_within(command->memory, command->output.parent_path(),
                         [&] { return align(*command); });
    };
  });
}

}  // namespace relief
