#include "apps/console/progress_plan.h"

#include <algorithm>

namespace relief {

std::vector<PlannedStage> stages_of_run(bool with_normals) {
  std::vector<PlannedStage> stages{{"read", 0.02}};
  const auto add_alignment = [&](const std::string& stage, double share) {
    stages.push_back({stage, 0.25 * share, "preparing views"});
    stages.push_back({stage, 0.15 * share, "refining poses"});
    stages.push_back({stage, 0.35 * share, "computing covariances"});
    stages.push_back({stage, 0.25 * share, "verifying poses"});
  };
  const auto add = [&](const std::string& stage, double share) {
    stages.push_back({stage, share});
  };
  add_alignment("align", with_normals ? 0.11 : 0.2);
  add("calibrate", with_normals ? 0.045 : 0.1);
  add("compare", with_normals ? 0.02 : 0.05);
  add("refine", with_normals ? 0.28 : 0.08);
  if (with_normals) add_alignment("align again", 0.08);
  add("write", with_normals ? 0.015 : 0.01);
  add("merge", with_normals ? 0.21 : 0.42);
  add("polish", with_normals ? 0.22 : 0.12);
  return stages;
}

double ProgressPlan::overall(std::string_view stage, std::string_view step, double fraction) {
  fraction = std::clamp(fraction, 0.0, 1.0);
  if (stages_.empty()) {
    overall_ = stage == stage_ ? std::max(overall_, fraction) : fraction;
    stage_ = stage;
    return overall_;
  }
  double before = 0.0, share = 0.0, sum = 0.0;
  bool reached = false;
  for (const PlannedStage& planned : stages_) {
    sum += planned.share;
    if (planned.name == stage && (planned.step.empty() || planned.step == step)) {
      reached = true;
      share = planned.share;
    } else if (!reached) {
      before += planned.share;
    }
  }
  if (reached) overall_ = std::max(overall_, (before + fraction * share) / sum);
  return overall_;
}

double ProgressPlan::seconds_left(double elapsed) const {
  constexpr double kEarliest = 0.02, kShortest = 1.0;  // Of the whole, and [s].
  if (overall_ < kEarliest || elapsed < kShortest) return -1.0;
  return elapsed * (1.0 - overall_) / overall_;
}

}  // namespace relief
