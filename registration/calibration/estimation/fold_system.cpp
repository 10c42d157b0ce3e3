#include "registration/calibration/estimation/fold_system.h"

#include "scan/base/parallel.h"

namespace relief::registration {

FoldSystem::FoldSystem(const std::vector<PairSums>& pairs, const Sensors& sensors,
                       const std::vector<bool>& held, bool per_view)
    : layout(sensors, held, per_view) {
  folds = parallel_map<Fold>(kFolds, [&](std::size_t f) {
    Fold fold;
    fold.own = sum_of_fold(pairs, f, sensors, layout);
    return fold;
  });
  QuadraticSum all(layout.poses + layout.coefficients);
  for (const Fold& fold : folds) all += fold.own;
  squares = all.squares;
  parallel_for(kFolds, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      Fold& fold = folds[f];
      fold.others = all;
      fold.others.matrix -= fold.own.matrix;
      fold.others.gradient -= fold.own.gradient;
      fold.poses_of_others = EliminatedPoses(fold.others, layout.poses);
    }
  });
}

}  // namespace relief::registration
