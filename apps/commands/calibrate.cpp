#include <filesystem>
#include <map>
#include <memory>

#include "apps/commands/command.h"
#include "apps/commands/outputs.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/output.h"
#include "apps/options/memory_option.h"
#include "apps/options/stage_options.h"
#include "apps/reports/stages/alignment_report.h"
#include "apps/reports/stages/calibration_report.h"
#include "relief/registration/align_views.h"
#include "relief/registration/calibrate_views.h"
#include "scan/base/stopwatch.h"

namespace relief {

namespace {

struct CalibrateCommand {
  CommonOptions common;
  ProjectInput input;
  registration::AlignOptions align;
  registration::CalibrationOptions options;
  MemoryFlag memory;
  std::filesystem::path output;
};

int calibrate(const CalibrateCommand& command) {
  const std::filesystem::path report_file =
      report_path(command.common, command.output / "scan.json");
  if (const auto free = check_outputs(command.input, {command.output, {report_file}}); !free)
    return fail(free.error());
  auto project = read_with_notes(command.input, command.common);
  if (!project) return fail(project.error());
  if (const auto ready = prepare_folder(command.output); !ready) return fail(ready.error());
  const auto alignment =
      registration::align_views(project->views, command.align, context_of(command.common, "align"));
  if (!alignment) return fail(alignment.error());
  const Stopwatch watch;
  const auto calibration =
      registration::calibrate_views(project->views, *alignment, command.align, command.options,
                                    context_of(command.common, "calibrate"));
  if (!calibration) return fail(calibration.error());
  registration::apply_alignment(*alignment, project->views);
  registration::apply_calibration(*calibration, project->views);
  const registration::Alignment& last = calibration->found() ? calibration->alignment : *alignment;
  Json report = calibration_report(*calibration, project->views);
  report["seconds"] = watch.seconds();
  log_calibration(*calibration, project->unit, report["seconds"]);
  warn_of_unverified(last);

  if (const auto written =
          write_project(*project, command.output, context_of(command.common, "write"));
      !written)
    return fail(written.error());
  const auto reported = write_report(report_file, "calibrate", report, command.common);
  if (!reported) return fail(reported.error());
  Console::info("wrote " + (command.output / "scan.json").string());
  return last.complete() && last.solved() ? kDone : kDataDoesNotAllow;
}

}  // namespace

void add_calibrate(CLI::App& app, Action& action) {
  auto command = std::make_shared<CalibrateCommand>();
  auto* sub = app.add_subcommand(
      "calibrate", "Align the views, and correct what the calibration of their sensors has wrong");
  add_project_input(*sub, command->input);
  command->input.options.for_alignment = true;
  add_background_option(*sub, command->input);
  sub->add_option("-o,--output", command->output, "Folder for the corrected project")->required();
  add_align_options(*sub, command->align);
  add_calibration_options(*sub, command->options);
  add_common_options(*sub, command->common);
  add_memory_option(*sub, command->memory, "views that do not fit lie in temporary files in DIR");
  sub->callback([command, &action] {
    action = [command] {
      return work_within(command->memory, command->output, [&] { return calibrate(*command); });
    };
  });
}

}  // namespace relief
