#include "apps/console/progress_plan.h"

#include <algorithm>

namespace relief {

namespace {

constexpr double kRead = 0.02;  // Of the whole: views are read before the plan is made.

// What the parts of `run` take; in any unit.
struct RunCosts {
  double align, calibrate, compare, refine, align_again, write, merge, polish;
};

// Measured on the demo, the bear and 16 views of a megapixel, on two threads [s]: a view takes 0.67
// s and a million samples 5.2 s to align, calibrate, compare and align again; a view takes 0.35 s
// and a million pixels of the parts that are refined 3.6 s to refine; a million samples 20 s to
// merge and polish. The three are off by no more than 35, 25 and 15 %.
RunCosts costs_with_normals(const ProjectSize& size) {
  const double aligned = 0.67 * static_cast<double>(size.views) + 5.2e-6 * size.samples;
  const double merged = 20e-6 * size.samples;
  return {.align = 0.45 * aligned,
          .calibrate = 0.2 * aligned,
          .compare = 0.08 * aligned,
          .refine = 0.35 * static_cast<double>(size.views) + 3.6e-6 * size.refined_pixels,
          .align_again = 0.27 * aligned,
          .write = 0.03 * merged,
          .merge = 0.51 * merged,
          .polish = 0.46 * merged};
}

constexpr RunCosts kCostsWithoutNormals{.align = 0.2,
                                        .calibrate = 0.1,
                                        .compare = 0.05,
                                        .refine = 0.08,
                                        .align_again = 0.0,
                                        .write = 0.01,
                                        .merge = 0.42,
                                        .polish = 0.12};

}  // namespace

std::vector<PlannedStage> stages_of_run(const ProjectSize& size) {
  const RunCosts costs =
      size.with_normals && size.samples > 0.0 ? costs_with_normals(size) : kCostsWithoutNormals;
  const double sum = costs.align + costs.calibrate + costs.compare + costs.refine +
                     costs.align_again + costs.write + costs.merge + costs.polish;
  std::vector<PlannedStage> stages{{"read", kRead}};
  const auto add = [&](const std::string& stage, double cost, const std::string& step = "") {
    stages.push_back({stage, (1.0 - kRead) * cost / sum, step});
  };
  const auto add_alignment = [&](const std::string& stage, double cost) {
    add(stage, 0.25 * cost, "preparing views");
    add(stage, 0.15 * cost, "refining poses");
    add(stage, 0.35 * cost, "computing covariances");
    add(stage, 0.25 * cost, "verifying poses");
  };
  add_alignment("align", costs.align);
  add("calibrate", costs.calibrate);
  add("compare", costs.compare);
  add("refine", costs.refine);
  if (costs.align_again > 0.0) add_alignment("align again", costs.align_again);
  add("write", costs.write);
  add("merge", costs.merge);
  add("polish", costs.polish);
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
