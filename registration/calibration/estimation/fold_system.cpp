#include "registration/calibration/estimation/fold_system.h"

#include <cstddef>
#include <utility>

#include "scan/base/parallel.h"

namespace relief::registration {

FoldSums empty_folds(const SystemLayout& layout) {
  FoldSums folds;
  folds.fill(SystemSum(layout));
  return folds;
}

void add_pair(const PairSums& pair, const Sensors& sensors, const SystemLayout& layout,
              FoldSums& folds) {
  for (std::size_t f = 0; f < kFolds; ++f) folds[f].add(pair, f, sensors, layout);
}

FoldSystem::FoldSystem(SystemLayout unknowns, FoldSums sums) : layout(std::move(unknowns)) {
  for (const SystemSum& sum : sums) squares += sum.squares;
  parallel_for(kFolds, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      folds[f].others = SystemSum(layout);
      for (std::size_t g = 0; g < kFolds; ++g)
        if (g != f) folds[f].others += sums[g];
      folds[f].poses_of_others = EliminatedPoses(folds[f].others, layout);
    }
  });
  for (std::size_t f = 0; f < kFolds; ++f) folds[f].own = std::move(sums[f]);
}

FoldSystem fold_system(const std::vector<PairSums>& pairs, const Sensors& sensors,
                       const std::vector<bool>& held, bool per_view) {
  const SystemLayout layout(sensors, held, per_view);
  FoldSums sums = empty_folds(layout);
  for (const PairSums& pair : pairs) add_pair(pair, sensors, layout, sums);
  return {layout, std::move(sums)};
}

}  // namespace relief::registration
