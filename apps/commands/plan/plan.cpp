#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "apps/commands/command.h"
#include "apps/commands/plan/step_costs.h"
#include "apps/commands/plan/step_states.h"
#include "apps/commands/run/run_options.h"
#include "apps/commands/step/view_choice.h"
#include "apps/console/exit_status.h"
#include "apps/reports/report.h"
#include "apps/version.h"
#include "scan/units/content_hash.h"

namespace relief {

namespace {

using reconstruction::ReconstructionPart;
using reconstruction::Stage;

constexpr double kMebibyte = 1 << 20;

struct PlanCommand {
  RunOptions run;
  std::size_t blocks = 0;       // Of views to refine; 0: as many as are worth it.
  std::size_t pair_blocks = 0;  // Of pairs to search; 0: as many as are worth it.
  std::size_t bricks = 0;       // Of the field, ahead of merging; 0: merging does all of it.
};

// A step, or one of several blocks of it.
struct PlannedStep {
  std::string name;  // `refine-2`, or that of the step.
  std::string step;
  std::vector<std::string> arguments, after;
  std::optional<Stage> stage;              // Nothing: `finish`.
  std::optional<ReconstructionPart> part;  // Nothing: the whole stage.
  StepCost cost;
  std::string state, depends_on;  // The latter where the state is `unknown`.
};

class Plan {
 public:
  explicit Plan(const PlanCommand& command) : command_(command), options_(command.run) {}

  int operator()() {
    auto project = read_with_notes(options_.input, options_.common);
    if (!project) return fail(project.error());
    project_ = std::move(*project);
    size_ = size_of(project_.views,
                    options_.align.starting_poses.given == registration::GivenPoses::kIgnore);
    add_steps();
    if (const auto found = find_states(); !found) return fail(found.error());
    if (options_.common.json || !options_.common.report.empty()) return tell_as_json();
    print();
    return kDone;
  }

 private:
  void add_steps() {
    const reconstruction::ReconstructionOptions options = options_.reconstruction();
    steps_ = blocks_of_pairs();
    std::vector<std::string> after = names_of(steps_);
    for (int i = 0; i < reconstruction::kStages; ++i) {
      const auto stage = static_cast<Stage>(i);
      if (!reconstruction::has_stage(stage, options)) continue;
      if (stage == Stage::kMerge) {
        std::vector<PlannedStep> ahead = parts_of_field(after);
        if (!ahead.empty()) after = names_of(ahead);
        steps_.insert(steps_.end(), ahead.begin(), ahead.end());
      }
      std::vector<PlannedStep> added =
          stage == Stage::kRefine ? blocks_of_views() : std::vector{PlannedStep()};
      for (PlannedStep& step : added) {
        step.step = reconstruction::step_name(stage);
        if (step.name.empty()) step.name = step.step;
        step.stage = stage;
        step.after = after;
        if (stage == Stage::kMerge && command_.bricks > 0)
          step.cost = cost_of_merge_after_parts(size_);
        else if (stage != Stage::kRefine)
          step.cost = cost_of(stage, size_);
      }
      after = names_of(added);
      steps_.insert(steps_.end(), added.begin(), added.end());
    }
    PlannedStep finish;
    finish.name = finish.step = "finish";
    finish.after = after;
    finish.cost = cost_of_finish(size_);
    steps_.push_back(std::move(finish));
  }

  static std::vector<std::string> names_of(const std::vector<PlannedStep>& steps) {
    std::vector<std::string> names;
    for (const PlannedStep& step : steps) names.push_back(step.name);
    return names;
  }

  // Block b of a step, of `count`.
  static PlannedStep block_of_step(const std::string& name, std::size_t b, std::size_t count) {
    PlannedStep step;
    step.step = name;
    step.name = name + "-" + std::to_string(b + 1);
    step.arguments = {"--block", std::to_string(b + 1) + "/" + std::to_string(count)};
    return step;
  }

  std::vector<PlannedStep> blocks_of_pairs() const {
    if (!size_.search) return {};
    const std::size_t blocks =
        command_.pair_blocks > 0 ? command_.pair_blocks : blocks_to_search(size_);
    std::vector<PlannedStep> steps;
    for (std::size_t b = 0; b < blocks; ++b) {
      PlannedStep step = block_of_step("pairs", b, blocks);
      step.stage = Stage::kAlign;
      step.part = {.last = Stage::kAlign, .searched_pairs = registration::PairBlock{b, blocks}};
      step.cost = cost_of_search(size_, blocks);
      steps.push_back(std::move(step));
    }
    return steps;
  }

  std::vector<PlannedStep> blocks_of_views() const {
    const std::size_t views = project_.views.size();
    const std::size_t blocks =
        std::clamp(command_.blocks > 0 ? command_.blocks : blocks_to_refine(size_), std::size_t{1},
                   std::max(views, std::size_t{1}));
    std::vector<PlannedStep> steps;
    for (std::size_t b = 0; b < blocks; ++b) {
      PlannedStep step = block_of_step("refine", b, blocks);
      const std::vector<std::size_t> block = block_of(views, {b, blocks});
      step.part = {.last = Stage::kRefine, .refined_views = block};
      double samples = 0.0;
      for (const std::size_t i : block)
        samples += static_cast<double>(project_.views[i].sample_count());
      step.cost = cost_of(Stage::kRefine, size_, samples / std::max(size_.samples, 1.0));
      steps.push_back(std::move(step));
    }
    return steps;
  }

  // The coarse levels, and after them the bricks of the finest. `after`: the steps before merging.
  std::vector<PlannedStep> parts_of_field(const std::vector<std::string>& after) const {
    if (command_.bricks == 0) return {};
    PlannedStep coarse;
    coarse.name = coarse.step = "coarse-field";
    coarse.part = {.last = Stage::kMerge, .field = fusion::FieldPart{}};
    coarse.after = after;
    coarse.cost = cost_of_coarse_field(size_);
    std::vector<PlannedStep> steps{std::move(coarse)};
    for (std::size_t b = 0; b < command_.bricks; ++b) {
      PlannedStep step = block_of_step("field", b, command_.bricks);
      step.part = {.last = Stage::kMerge, .field = fusion::FieldPart{b, command_.bricks}};
      step.after = {steps.front().name};
      step.cost = cost_of_brick(size_, command_.bricks);
      steps.push_back(std::move(step));
    }
    for (PlannedStep& step : steps) step.stage = Stage::kMerge;
    return steps;
  }

  // Keys depend on the results of the steps before, so they are known up to the first one missing.
  Result<void> find_states() {
    std::vector<ReconstructionPart> parts;
    for (const PlannedStep& step : steps_)
      if (step.part) parts.push_back(*step.part);
    const auto states =
        find_steps(project_.views, parts, options_.reconstruction(), options_.output,
                   context_of(options_.common, "look for results"));
    if (!states) return states.error();
    std::size_t part = 0;
    for (PlannedStep& step : steps_) {
      if (!step.stage && !states->first_missing) {
        step.state = "missing";  // Its files have no keys: it is done whenever it is asked for.
      } else if (!states->first_missing || (step.stage && *step.stage < *states->first_missing)) {
        step.state = "done";
      } else if (step.stage == states->first_missing) {
        step.state = step.part && is_set(states->parts_done, part++) ? "done" : "missing";
      } else {
        step.state = "unknown";
        step.depends_on = reconstruction::step_name(*states->first_missing);
      }
    }
    return {};
  }

  static bool is_set(const std::vector<bool>& flags, std::size_t i) {
    return i < flags.size() && flags[i];
  }

  Json to_json(const PlannedStep& step) const {
    Json json{{"name", step.name},
              {"step", step.step},
              {"arguments", step.arguments},
              {"after", step.after},
              {"state", step.state}};
    if (!step.depends_on.empty()) json["depends_on"] = step.depends_on;
    if (step.stage == Stage::kRefine) {
      json["views"] = Json::array();
      for (const std::size_t i : *step.part->refined_views)
        json["views"].push_back(project_.views[i].name);
    }
    json["cpu_seconds"] = step.cost.cpu_seconds;
    json["memory_mb"] = step.cost.memory_bytes / kMebibyte;
    json["disk_mb"] = step.cost.disk_bytes / kMebibyte;
    return json;
  }

  int tell_as_json() const {
    Json plan{{"relief", kVersion},
              {"program", program_identity()},
              {"project", options_.input.path.string()},
              {"output", options_.output.string()},
              {"views", size_.views},
              {"pixels", size_.pixels},
              {"samples", size_.samples}};
    plan["steps"] = Json::array();
    for (const PlannedStep& step : steps_) plan["steps"].push_back(to_json(step));
    if (options_.common.json) std::cout << plan.dump(2) << std::endl;
    if (options_.common.report.empty()) return kDone;
    CommonOptions silent = options_.common;
    silent.json = false;
    const auto written = write_report(options_.common.report, "plan", plan, silent);
    return written ? static_cast<int>(kDone) : fail(written.error());
  }

  void print() const {
    std::cout << "program " << program_identity() << "\n";
    std::cout << fmt::format("{:<12} {:>12} {:>12} {:>12}  {}\n", "step", "processor", "memory",
                             "disk", "state");
    StepCost sum;
    for (const PlannedStep& step : steps_) {
      std::cout << line(step.name, step.cost,
                        step.state == "unknown" ? "depends on " + step.depends_on : step.state);
      sum.cpu_seconds += step.cost.cpu_seconds;
      sum.memory_bytes = std::max(sum.memory_bytes, step.cost.memory_bytes);
      sum.disk_bytes += step.cost.disk_bytes;
    }
    std::cout << line("together", sum, "") << std::flush;
  }

  static std::string line(const std::string& name, const StepCost& cost, const std::string& state) {
    return fmt::format("{:<12} {:>10.1f} s {:>8.0f} MiB {:>8.1f} MiB  {}\n", name, cost.cpu_seconds,
                       cost.memory_bytes / kMebibyte, cost.disk_bytes / kMebibyte, state);
  }

  const PlanCommand& command_;
  const RunOptions& options_;
  ScanProject project_;
  ProjectSize size_;
  std::vector<PlannedStep> steps_;
};

}  // namespace

void add_plan(CLI::App& app, Action& action) {
  auto command = std::make_shared<PlanCommand>();
  auto* sub = app.add_subcommand(
      "plan",
      "The steps of `run` with the same options: what comes after what, what is there already, and "
      "estimates of processor time, memory and disk");
  add_run_options(*sub, command->run);
  sub->add_option("--blocks", command->blocks,
                  "Blocks in which the views are refined; 0: as many as are worth it")
      ->capture_default_str();
  sub->add_option("--pair-blocks", command->pair_blocks,
                  "Blocks in which pairs of views are searched where poses are missing; 0: as many "
                  "as are worth it")
      ->capture_default_str();
  sub->add_option(
         "--bricks", command->bricks,
         "Bricks of the finest level of the field, integrated ahead of merging; 0: merging "
         "does all of it")
      ->capture_default_str();
  sub->callback([command, &action] { action = [command] { return Plan(*command)(); }; });
}

}  // namespace relief
