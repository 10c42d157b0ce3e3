#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/commands/command.h"
#include "apps/commands/run/run_cache.h"
#include "apps/commands/run/run_options.h"
#include "apps/commands/step/view_choice.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/interruption.h"
#include "apps/console/output.h"
#include "apps/console/progress_display.h"
#include "apps/reports/run_record.h"
#include "apps/reports/stages/alignment_report.h"
#include "apps/reports/stages/calibration_report.h"
#include "apps/reports/stages/consistency_report.h"
#include "apps/reports/stages/model_report.h"
#include "apps/reports/stages/refinement_report.h"
#include "scan/base/stopwatch.h"

namespace relief {

namespace {

using reconstruction::Stage;

constexpr Stage kStagesOfSteps[] = {Stage::kAlign,  Stage::kCalibrate,  Stage::kCompare,
                                    Stage::kRefine, Stage::kAlignAgain, Stage::kMerge,
                                    Stage::kPolish};
// Ahead of aligning and of merging: parts of them.
constexpr const char* kPairs = "pairs";
constexpr const char* kCoarseField = "coarse-field";
constexpr const char* kField = "field";
constexpr const char* kFinish = "finish";  // After all stages: decimation, and what is written.

std::vector<std::string> step_names() {
  std::vector<std::string> names{kPairs};
  for (const Stage stage : kStagesOfSteps) {
    if (stage == Stage::kMerge) names.insert(names.end(), {kCoarseField, kField});
    names.push_back(reconstruction::step_name(stage));
  }
  names.emplace_back(kFinish);
  return names;
}

struct StepCommand {
  RunOptions run;
  std::string name;
  ViewChoice views;
  bool require_inputs = false;

  bool is_part_of_field() const { return name == kCoarseField || name == kField; }
  bool is_cut_into_blocks() const { return name == kPairs || name == kField; }

  // The stage that the step is, or is a part of. Nothing: `finish`.
  std::optional<Stage> stage() const {
    if (name == kPairs) return Stage::kAlign;
    if (is_part_of_field()) return Stage::kMerge;
    for (const Stage stage : kStagesOfSteps)
      if (reconstruction::step_name(stage) == name) return stage;
    return std::nullopt;
  }
};

class Step {
 public:
  Step(const StepCommand& command, Stage stage)
      : command_(command), options_(command.run), stage_(stage) {}

  int operator()() {
    if (options_.time_limit > 0.0) stop_after(std::chrono::duration<double>(options_.time_limit));
    if (const auto free = check_outputs(options_.input, options_.outputs()); !free)
      return fail(free.error());
    auto project = read_with_notes(options_.input, options_.common);
    if (!project) return fail(project.error());
    unit_ = project->unit;
    const auto part = part_of(project->views);
    if (!part) return fail(part.error());
    if (const auto ready = prepare_folder(options_.output); !ready) return fail(ready.error());
    if (const auto shared = cache_.open_for_step(options_.output, options_.cache); !shared)
      return fail(shared.error());
    plan_progress({{"read", 0.05}, {std::string(to_string(stage_)), 0.95}});
    watch_ = Stopwatch();
    const auto result = reconstruction::reconstruct_part(
        std::move(project->views), *part, options_.reconstruction(),
        options_.context(cache_.store()), callbacks());
    if (!result) return stop(result.error());
    if (stage_ >= Stage::kMerge && !command_.is_part_of_field())
      log_model(result->model, unit_, watch_.seconds());
    if (const auto kept = cache_.all_kept(); !kept) return stop(kept.error());
    if (const auto told = report(); !told) return fail(told.error());
    return kDone;
  }

 private:
  Result<reconstruction::ReconstructionPart> part_of(const std::vector<RangeView>& views) const {
    reconstruction::ReconstructionPart part;
    part.last = stage_;
    part.find_former = command_.require_inputs;
    if (command_.is_cut_into_blocks()) {
      const auto block = chosen_block(command_.views);
      if (!block) return block.error();
      if (command_.name == kPairs)
        part.searched_pairs = registration::PairBlock{block->index, block->count};
      else
        part.field = fusion::FieldPart{block->index, block->count};
    } else if (command_.name == kCoarseField) {
      part.field = fusion::FieldPart{};
    } else {
      auto chosen = chosen_views(command_.views, views);
      if (!chosen) return chosen.error();
      part.refined_views = std::move(*chosen);
    }
    return part;
  }

  int stop(const Error& error) {
    Error with_folder = error;
    if (command_.require_inputs && error.kind == ErrorKind::kBadInput)
      with_folder.message = options_.output.string() + ": " + error.message;
    const int status = fail(with_folder);
    cache_.log_kept();
    return status;
  }

  // The messages of `run`, of this stage only.
  reconstruction::ReconstructionCallbacks callbacks() const {
    reconstruction::ReconstructionCallbacks callbacks;
    callbacks.progress = console_stage_progress();
    callbacks.aligned = [this](const registration::Alignment& alignment) {
      if (stage_ == Stage::kAlign) {
        log_alignment(alignment, unit_, watch_.seconds());
        warn_of_unverified(alignment);
      }
      return Result<void>{};
    };
    callbacks.calibrated = [this](const registration::SensorCalibration& calibration,
                                  const std::vector<RangeView>&) {
      if (stage_ == Stage::kCalibrate) log_calibration(calibration, unit_, watch_.seconds());
      return Result<void>{};
    };
    callbacks.compared = [this](const std::vector<reconstruction::ViewConsistency>& consistency,
                                const std::vector<RangeView>& views) {
      if (stage_ == Stage::kCompare) log_consistency(consistency, views, unit_, watch_.seconds());
      return Result<void>{};
    };
    callbacks.refined = [this](const std::vector<hybrid::RefineSummary>& refinements,
                               const std::vector<RangeView>& views) {
      if (stage_ == Stage::kRefine) log_refinement(refinements, views, unit_, watch_.seconds());
      return Result<void>{};
    };
    callbacks.aligned_again = [this](const reconstruction::SecondAlignment& second) {
      if (stage_ == Stage::kAlignAgain) {
        log_alignment(second.alignment, unit_, watch_.seconds());
        log_gain(second.gain, unit_);
      }
      return Result<void>{};
    };
    return callbacks;
  }

  // Into a file only where one is named: steps that run side by side have no file in common.
  Result<void> report() const {
    const auto [found, computed] = cache_.sum();
    Console::info("step " + command_.name + " is done: " + std::to_string(computed) +
                  " results computed, " + std::to_string(found) + " found");
    const Json section{{"step", command_.name},
                       {"program", options_.record["program"]},
                       {"units", cache_.report()},
                       {"seconds", watch_.seconds()},
                       {"peak_memory_mb", peak_memory_mb()}};
    if (!options_.common.report.empty())
      return write_report(options_.common.report, "step", section, options_.common);
    if (options_.common.json) std::cout << section.dump(2) << std::endl;
    return {};
  }

  const StepCommand& command_;
  const RunOptions& options_;
  const Stage stage_;
  std::string unit_;
  RunCache cache_;
  Stopwatch watch_;
};

int carry_out_step(const StepCommand& command) {
  const auto stage = command.stage();
  const bool takes_choice =
      stage == Stage::kRefine || (command.is_cut_into_blocks() && !command.views.chooses_views());
  if (command.views.given() && !takes_choice)
    return fail({ErrorKind::kBadInput, "step " + command.name +
                                           " works on all views: only refine takes VIEW and "
                                           "--views, only refine, pairs and field take --block"});
  if (stage)
    return work_within(command.run.memory, command.run.output,
                       [&] { return Step(command, *stage)(); });
  reconstruction::ReconstructionPart part;
  part.find_former = part.find_last = command.require_inputs;
  return run(command.run, part);
}

}  // namespace

void add_step(CLI::App& app, Action& action) {
  auto command = std::make_shared<StepCommand>();
  auto* sub = app.add_subcommand(
      "step",
      "One step of `run`, with the options of `run`; the results go to DIR/.relief, where the next "
      "step and `run` find them");
  sub->add_option(
         "step", command->name,
         "pairs (part of align that may be done ahead, in blocks), align, calibrate, "
         "compare, refine, align-again, coarse-field and field (parts of merge that may be "
         "done ahead, the second in blocks), merge, polish, or finish (what `run` does "
         "after the others)")
      ->required()
      ->check(CLI::IsMember(step_names()));
  add_run_options(*sub, command->run);
  add_view_choice(*sub, command->views);
  sub->add_flag("--require-inputs", command->require_inputs,
                "End with an error that names the step whose results are missing; default: they "
                "are computed");
  sub->callback([command, sub, &action] {
    command->run.record = run_record(command->run.input.path, *sub);
    action = [command] { return carry_out_step(*command); };
  });
}

}  // namespace relief
