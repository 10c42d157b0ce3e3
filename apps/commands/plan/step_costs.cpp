#include "apps/commands/plan/step_costs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace relief {

namespace {

using reconstruction::Stage;

// Costs are sums of these parts. bench/step_costs fits the numbers to what it measures on simulated
// sets and on the bear, whose views are masked: processor time and memory are off by 30 % at most
// for sets of 0.3 million samples or more (docs/results.md, On a cluster).
struct CostModel {
  double cpu_per_pixel, cpu_per_sample, cpu_per_pair;  // [s], the first two per million
  double memory_per_pixel, memory_per_sample;          // [bytes]
  double disk_per_pixel, disk_per_sample;              // [bytes]
};

// Of what `run` does after all stages.
constexpr CostModel kFinish{0.0, 13.3, 0.0, 20.0, 244.0, 0.0, 0.0};

constexpr double kMillion = 1e6;
constexpr double kProgram = 60e6;  // Memory of the program alone [bytes].
// Processor time of a pair whose pose is looked for by shape, its share of whether views fit
// themselves included [s]: of the bunny, the bear and the dragon.
constexpr double kSearchedPair = 0.2;
// Pairs that are searched in all, of the first ones: 1 to 1.5 of them where the views fit together.
constexpr double kAllSearched = 1.5;

// Of what searching pairs begins with.
constexpr CostModel kDescribe{0.35, 6.5, 0.0, 23.0, 240.0, 0.0, 0.0};
// Blocks of less processor time are not worth a process [s].
constexpr double kLeastBlock = 10.0;

// Of what is done ahead of merging: the coarse field, what each brick begins with, and what the
// bricks share.
constexpr CostModel kCoarseField{0.56, 14.0, 0.0, 47.0, 40.0, 0.0, 22.0};
constexpr CostModel kEachBrick{0.46, 12.0, 0.0, 21.0, 260.0, 0.0, 0.0};
constexpr CostModel kAllBricks{0.0, 7.0, 0.0, 0.0, 0.0, 0.0, 69.0};
constexpr CostModel kMergeAfterParts{0.56, 18.0, 0.0, 19.0, 265.0, 0.0, 33.0};

const CostModel& model_of(Stage stage) {
  static constexpr CostModel kAlign{0.35, 9.2, 0.054, 23.0, 240.0, 0.0, 1.0};
  static constexpr CostModel kCalibrate{0.22, 5.3, 0.028, 44.0, 149.0, 0.0, 1.0};
  static constexpr CostModel kCompare{0.25, 7.6, 0.0, 37.0, 0.0, 5.0, 0.0};
  static constexpr CostModel kRefine{1.4, 32.0, 0.0, 49.0, 72.0, 25.0, 0.0};
  static constexpr CostModel kAlignAgain{0.7, 8.1, 0.026, 42.0, 59.0, 0.0, 1.0};
  static constexpr CostModel kMerge{0.56, 29.0, 0.0, 18.0, 281.0, 0.0, 56.0};
  static constexpr CostModel kPolish{0.2, 22.0, 0.0, 24.0, 207.0, 0.0, 33.0};
  switch (stage) {
    case Stage::kAlign:
      return kAlign;
    case Stage::kAlignAgain:
      return kAlignAgain;
    case Stage::kCalibrate:
      return kCalibrate;
    case Stage::kCompare:
      return kCompare;
    case Stage::kRefine:
      return kRefine;
    case Stage::kMerge:
      return kMerge;
    case Stage::kPolish:
      break;
  }
  return kPolish;
}

// `share` of the samples: what depends on all pixels is reading the project and the results.
StepCost cost_by(const CostModel& model, const ProjectSize& size, double share) {
  const double samples = share * size.samples;
  return {model.cpu_per_pixel * size.pixels / kMillion + model.cpu_per_sample * samples / kMillion +
              model.cpu_per_pair * static_cast<double>(size.pairs),
          kProgram + model.memory_per_pixel * size.pixels + model.memory_per_sample * samples,
          model.disk_per_pixel * share * size.pixels + model.disk_per_sample * samples};
}

}  // namespace

StepCost cost_of(reconstruction::Stage stage, const ProjectSize& size, double share) {
  // Without normals nothing is refined, and nothing aligned again.
  const bool idle = !size.with_normals && (stage == Stage::kRefine || stage == Stage::kAlignAgain);
  ProjectSize worked = size;
  if (idle) {
    worked.samples = 0.0;
    worked.pairs = 0;
  }
  StepCost cost = cost_by(model_of(stage), worked, share);
  if (stage == Stage::kAlign && size.search)
    cost.cpu_seconds += kAllSearched * kSearchedPair * static_cast<double>(size.first_pairs);
  return cost;
}

StepCost cost_of_finish(const ProjectSize& size) { return cost_by(kFinish, size, 1.0); }

StepCost cost_of_search(const ProjectSize& size, std::size_t blocks) {
  // Each process describes all views.
  ProjectSize read = size;
  read.pairs = 0;
  StepCost cost = cost_by(kDescribe, read, 1.0);
  cost.cpu_seconds += kSearchedPair * static_cast<double>(size.first_pairs) /
                      static_cast<double>(std::max(blocks, std::size_t{1}));
  return cost;
}

StepCost cost_of_coarse_field(const ProjectSize& size) { return cost_by(kCoarseField, size, 1.0); }

StepCost cost_of_brick(const ProjectSize& size, std::size_t bricks) {
  StepCost cost = cost_by(kEachBrick, size, 1.0);
  const StepCost all = cost_by(kAllBricks, size, 1.0);
  const auto count = static_cast<double>(std::max(bricks, std::size_t{1}));
  cost.cpu_seconds += all.cpu_seconds / count;
  cost.disk_bytes += all.disk_bytes / count;
  return cost;
}

StepCost cost_of_merge_after_parts(const ProjectSize& size) {
  return cost_by(kMergeAfterParts, size, 1.0);
}

std::size_t blocks_to_search(const ProjectSize& size) {
  if (!size.search) return 0;
  const double own = kSearchedPair * static_cast<double>(size.first_pairs);
  const double shared = cost_of_search(size, 1).cpu_seconds - own;
  const auto blocks = static_cast<std::size_t>(
      std::min(own / std::max(shared, kLeastBlock), static_cast<double>(size.views)));
  return blocks > 1 ? blocks : 0;
}

std::size_t blocks_to_refine(const ProjectSize& size) {
  const StepCost all = cost_of(Stage::kRefine, size), none = cost_of(Stage::kRefine, size, 0.0);
  const double own = all.cpu_seconds - none.cpu_seconds;
  const double worthwhile = std::floor(own / std::max(none.cpu_seconds, 1e-3));
  return std::max(std::size_t{1},
                  std::min(size.views, static_cast<std::size_t>(std::max(worthwhile, 1.0))));
}

}  // namespace relief
