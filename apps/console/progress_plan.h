#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "apps/commands/plan/project_size.h"

namespace relief {

/// A stage of a command, or a step of it, and its share of the command's time.
struct PlannedStage {
  std::string name;
  double share = 0.0;
  std::string step = {};  ///< Empty: the whole stage, whatever its steps.
};

/// The stages of `run`, with shares that sum to 1. With normals they follow the size of the views;
/// without, they are those of the bunny: refining, aligning again and polishing are short there.
std::vector<PlannedStage> stages_of_run(const ProjectSize& size);

/// How far a command of several stages is. Never goes back: a stage that is left out counts as done
/// as soon as a later one has begun.
class ProgressPlan {
 public:
  /// Shares need not sum to 1. Without stages each stage is the whole.
  explicit ProgressPlan(std::vector<PlannedStage> stages = {}) : stages_(std::move(stages)) {}

  /// The fraction of the whole when a step of a stage is `fraction` of its way; of what is not
  /// planned, as before.
  double overall(std::string_view stage, std::string_view step, double fraction);

  /// The time that the rest takes at the rate so far [s]; negative: too early to tell.
  double seconds_left(double elapsed) const;

 private:
  std::vector<PlannedStage> stages_;
  double overall_ = 0.0;
  std::string stage_;  // The current one, where none is planned.
};

}  // namespace relief
