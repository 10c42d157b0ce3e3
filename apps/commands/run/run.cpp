#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/convert/export_views.h"
#include "apps/commands/plan/project_size.h"
#include "apps/commands/run/run_cache.h"
#include "apps/commands/run/run_options.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/interruption.h"
#include "apps/console/output.h"
#include "apps/console/progress_display.h"
#include "apps/reports/html/html_report.h"
#include "apps/reports/html/views/view_pictures.h"
#include "apps/reports/run_record.h"
#include "apps/reports/stages/alignment_report.h"
#include "apps/reports/stages/calibration_report.h"
#include "apps/reports/stages/consistency_report.h"
#include "apps/reports/stages/model_report.h"
#include "apps/reports/stages/refinement_report.h"
#include "relief/io/mesh_io.h"
#include "relief/reconstruction/reconstruct_part.h"
#include "scan/base/stopwatch.h"

namespace relief {

namespace {

class Run {
 public:
  Run(const RunOptions& command, const reconstruction::ReconstructionPart& part)
      : command_(command), part_(part), record_(command.record) {}

  // What a stage achieved is written before the next one starts.
  int operator()() {
    if (command_.time_limit > 0.0) stop_after(std::chrono::duration<double>(command_.time_limit));
    if (const auto free = check_outputs(command_.input, command_.outputs()); !free)
      return fail(free.error());
    auto project = read_with_notes(
        command_.input, command_.common,
        [this](const std::vector<RangeView>& v) { record_["inputs"] = input_record(v); });
    if (!project) return fail(project.error());
    record_["notes"] = project->notes;
    if (const auto can = check_exports_of_results(project->views, command_.exports); !can)
      return fail(can.error());
    if (const auto ready = prepare_folder(command_.output); !ready) return fail(ready.error());
    if (const auto ours = cache_.open(command_.output, command_.cache); !ours)
      return fail(ours.error());
    project_ = std::move(*project);
    if (const auto kept = keep("run", record_); !kept) return fail(kept.error());
    plan_progress(stages_of_run(size_of(project_.views, /*ignore_poses=*/false)));
    if (!command_.no_html_report) pictures_.draw_measured(project_.views);
    watch_ = Stopwatch();
    auto result = reconstruction::reconstruct_part(std::move(project_.views), part_,
                                                   command_.reconstruction(),
                                                   command_.context(cache_.store()), callbacks());
    if (!result) return stop(result.error());
    cache_.log("merge", "merged mesh");
    cache_.log("polish", "polished mesh");
    if (const auto written = write_model(result->model); !written) return stop(written.error());
    Console::info("wrote " + (command_.output / "model.ply").string() + " and report.json");
    if (const auto written = write_page(result->model.mesh); !written) return stop(written.error());
    return result->complete() ? kDone : kDataDoesNotAllow;
  }

 private:
  int stop(const Error& error) {
    const int status = fail(error);
    cache_.log_kept();
    return status;
  }

  Context context(const std::string& stage) const { return context_of(command_.common, stage); }

  reconstruction::ReconstructionCallbacks callbacks() {
    reconstruction::ReconstructionCallbacks callbacks;
    callbacks.progress = console_stage_progress();
    callbacks.aligned = [this](const registration::Alignment& alignment) {
      return keep_alignment(alignment);
    };
    callbacks.calibrated = [this](const registration::SensorCalibration& calibration,
                                  const std::vector<RangeView>& views) {
      return keep_calibration(calibration, views);
    };
    callbacks.compared = [this](const std::vector<reconstruction::ViewConsistency>& consistency,
                                const std::vector<RangeView>& views) {
      return keep_consistency(consistency, views);
    };
    callbacks.refined = [this](const std::vector<hybrid::RefineSummary>& refinements,
                               const std::vector<RangeView>& views) {
      return keep_refinement(refinements, views);
    };
    callbacks.aligned_again = [this](const reconstruction::SecondAlignment& second) {
      return keep_second_alignment(second);
    };
    callbacks.views_finished = [this](const std::vector<RangeView>& views) {
      return write_views(views);
    };
    return callbacks;
  }

  Result<void> keep_alignment(const registration::Alignment& alignment) {
    cache_.log("align", "alignment");
    Json report = to_json(alignment);
    align_seconds_ = watch_.seconds();
    report["seconds"] = align_seconds_;
    log_alignment(alignment, project_.unit, align_seconds_);
    warn_of_unverified(alignment);
    return keep("align", report);
  }

  Result<void> keep_calibration(const registration::SensorCalibration& calibration,
                                const std::vector<RangeView>& views) {
    cache_.log("calibrate", "calibration");
    Json report = calibration_report(calibration, views);
    report["seconds"] = watch_.seconds();
    log_calibration(calibration, project_.unit, report["seconds"]);
    if (auto kept = keep("calibrate", report); !kept || !calibration.found()) return kept;
    Json alignment = to_json(calibration.alignment);
    alignment["seconds"] = align_seconds_;
    return keep("align", alignment);
  }

  Result<void> keep_consistency(const std::vector<reconstruction::ViewConsistency>& consistency,
                                const std::vector<RangeView>& views) {
    cache_.log("compare", "comparison of the views");
    Json report = consistency_report(consistency, views);
    report["seconds"] = watch_.seconds();
    log_consistency(consistency, views, project_.unit, report["seconds"]);
    return keep("compare", report);
  }

  Result<void> keep_refinement(const std::vector<hybrid::RefineSummary>& refinements,
                               const std::vector<RangeView>& views) {
    cache_.log("refine", "refined views");
    Json report = refinement_report(refinements, views);
    report["seconds"] = watch_.seconds();
    log_refinement(refinements, views, project_.unit, report["seconds"]);
    if (const auto drawn = pictures_.write(views, refinements, command_.output, report); !drawn)
      return drawn;
    return keep("refine", report);
  }

  Result<void> keep_second_alignment(const reconstruction::SecondAlignment& second) {
    cache_.log("align_again", "second alignment");
    Json report = to_json(second.alignment);
    report["seconds"] = watch_.seconds();
    report["gain"] = to_json(second.gain);
    log_alignment(second.alignment, project_.unit, report["seconds"]);
    log_gain(second.gain, project_.unit);
    return keep("align_again", report);
  }

  Result<void> write_views(const std::vector<RangeView>& views) {
    auto written = write_project(views, project_.unit, command_.output, context("write"));
    if (written && !command_.exports.empty())
      written = export_all({project_.unit, views, {}}, command_.output / "scan.json", {},
                           command_.exports);
    watch_ = Stopwatch();
    return written;
  }

  Result<void> write_model(const reconstruction::Model& model) {
    Json report = to_json(model);
    report["seconds"] = watch_.seconds();
    report["peak_memory_mb"] = peak_memory_mb();
    log_model(model, project_.unit, report["seconds"]);
    if (auto written = write_mesh(model.mesh, command_.output / "model.ply"); !written)
      return written;
    record_["cache"] = cache_.report();
    if (auto kept = keep("run", record_); !kept) return kept;
    return write_report(report_path(command_.common, command_.output / "scan.json"), "merge",
                        report, command_.common);
  }

  Result<void> write_page(const TriangleMesh& mesh) {
    if (command_.no_html_report) return {};
    HtmlReportOptions options = command_.html;
    return run_in(context("report"), [&] {
      return write_html_report(
          {.page = command_.output / "report.html",
           .report = report_path(command_.common, command_.output / "scan.json"),
           .folder = command_.output},
          &mesh, options);
    });
  }

  // Into the report file; standard output gets the whole report once, at the end.
  Result<void> keep(const std::string& section, const Json& report) {
    watch_ = Stopwatch();
    CommonOptions silent = command_.common;
    silent.json = false;
    return write_report(report_path(silent, command_.output / "scan.json"), section, report,
                        silent);
  }

  const RunOptions& command_;
  const reconstruction::ReconstructionPart& part_;
  Json record_;          // The section `run` of the report.
  ScanProject project_;  // Its views are given away.
  RunCache cache_;
  ViewPictures pictures_;
  Stopwatch watch_;  // Of the stage.
  double align_seconds_ = 0.0;
};

}  // namespace

int run(const RunOptions& options, const reconstruction::ReconstructionPart& part) {
  return work_within(options.memory, options.output, [&] { return Run(options, part)(); });
}

void add_run(CLI::App& app, Action& action) {
  auto command = std::make_shared<RunOptions>();
  auto* sub = app.add_subcommand("run", "Align, refine, align again and merge: the whole way");
  add_run_options(*sub, *command);
  sub->callback([command, sub, &action] {
    command->record = run_record(command->input.path, *sub);
    action = [command] { return run(*command); };
  });
}

}  // namespace relief
