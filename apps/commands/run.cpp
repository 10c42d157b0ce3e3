#include <memory>

#include "apps/commands/command.h"
#include "apps/options/stage_options.h"
#include "apps/reports/console.h"
#include "apps/reports/exit_status.h"
#include "apps/reports/output.h"
#include "apps/stages/alignment_gain.h"
#include "apps/stages/stages.h"
#include "relief/io/mesh_io.h"

namespace relief {

namespace {

struct RunCommand {
  CommonOptions common;
  ProjectInput input;
  registration::AlignOptions align;
  RefineFlags refine;
  MergeFlags merge;
  std::filesystem::path output;
};

// Views that fit nowhere would only spoil the model.
void drop_unaligned(ScanProject& project, const Json& align_report) {
  std::vector<RangeView> kept;
  for (std::size_t i = 0; i < project.views.size(); ++i)
    if (align_report["views"][i]["aligned"]) kept.push_back(std::move(project.views[i]));
  project.views = std::move(kept);
}

class Run {
 public:
  explicit Run(const RunCommand& command) : command_(command) {}

  // align, refine, align again on the refined surfaces, merge. What a stage achieved is written
  // before the next one starts.
  int operator()() {
    auto project = read_with_notes(command_.input, command_.common);
    if (!project) return fail(project.error());
    if (const auto ready = prepare_folder(command_.output); !ready) return fail(ready.error());
    project_ = std::move(*project);
    for (const auto stage : {&Run::align, &Run::refine, &Run::align_again, &Run::merge}) {
      const Result<void> done = (this->*stage)();
      if (!done) return fail(done.error());
    }
    Console::info("wrote " + (command_.output / "model.ply").string() + " and report.json");
    return complete_ ? kDone : kDataDoesNotAllow;
  }

 private:
  Result<void> align() {
    const auto stage = align_stage(project_, with_threads(command_.align));
    if (!stage) return stage.error();
    warn_of_unaligned(stage->report);
    if (auto written = keep("align", stage->report); !written) return written;
    first_alignment_ = stage->report;
    if (!stage->complete) {
      complete_ = false;
      drop_unaligned(project_, stage->report);
    }
    if (project_.views.empty())
      return Error{ErrorKind::kUnsolvable, "no view could be aligned: nothing to merge"};
    return {};
  }

  Result<void> refine() {
    hybrid::RefineOptions options = with_threads(command_.refine.resolved());
    options.seed = command_.common.seed;
    const auto stage = refine_stage(project_, options, command_.refine.memory());
    if (!stage) return stage.error();
    complete_ = complete_ && stage->complete;
    any_refined_ = stage->any_refined;
    return keep("refine", stage->report);
  }

  Result<void> align_again() {
    if (any_refined_ && project_.views.size() > 1) {
      std::vector<RigidMotion> before;
      for (const RangeView& view : project_.views) before.push_back(view.world_from_view);
      registration::AlignOptions options = with_threads(command_.align);
      options.surface.normals = registration::NormalSource::kMeasured;
      auto stage = align_stage(project_, options);
      if (!stage) return stage.error();
      const Json gain = alignment_gain(first_alignment_, stage->report, project_.views);
      for (const std::string& line : gain_table(gain, project_.unit)) Console::info(line);
      stage->report["gain"] = gain;
      if (!gain["kept"]) restore_poses(before);
      if (auto written = keep("align_again", stage->report); !written) return written;
    }
    return write_project(project_, command_.output, console_progress("write"));
  }

  void restore_poses(const std::vector<RigidMotion>& poses) {
    for (std::size_t i = 0; i < poses.size(); ++i) project_.views[i].world_from_view = poses[i];
  }

  Result<void> merge() {
    const auto stage = merge_stage(project_, with_threads(command_.merge.resolved()));
    if (!stage) return stage.error();
    if (auto written = write_mesh(stage->mesh, command_.output / "model.ply"); !written)
      return written;
    return write_report(report_path(command_.common, command_.output / "scan.json"), "merge",
                        stage->report, command_.common);
  }

  // Into the report file; standard output gets the whole report once, at the end.
  Result<void> keep(const std::string& section, const Json& report) {
    CommonOptions silent = command_.common;
    silent.json = false;
    return write_report(report_path(silent, command_.output / "scan.json"), section, report,
                        silent);
  }

  template <typename Options>
  Options with_threads(Options options) const {
    options.threads = command_.common.threads;
    return options;
  }

  const RunCommand& command_;
  ScanProject project_;
  Json first_alignment_;  // Its section of the report.
  bool complete_ = true;
  bool any_refined_ = false;
};

}  // namespace

void add_run(CLI::App& app, Action& action) {
  auto command = std::make_shared<RunCommand>();
  auto* sub = app.add_subcommand("run", "Align, refine, align again and merge: the whole way");
  add_project_input(*sub, command->input);
  add_background_option(*sub, command->input);
  sub->add_option("-o,--output", command->output,
                  "Folder for model.ply, the refined project (scan.json) and report.json")
      ->required();
  add_align_options(*sub, command->align);
  add_refine_options(*sub, command->refine);
  add_merge_options(*sub, command->merge);
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return Run(*command)(); }; });
}

}  // namespace relief
