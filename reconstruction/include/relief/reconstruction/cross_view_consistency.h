#pragma once

#include <cstddef>
#include <vector>

#include "relief/registration/pair_fit.h"
#include "relief/scan/progress.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::reconstruction {

/// What the other views say of the ranges of one view.
struct ViewConsistency {
  std::size_t compared = 0;      ///< Samples that two other views or more measured as well.
  std::size_t contradicted = 0;  ///< Those that count less now.
  /// Robust standard deviation of the distance to the others' surfaces [unit]; 0: none compared.
  double deviation = 0.0;
};

/// Lowers the confidence of patches where one view's ranges are wrong: in highlights, for instance,
/// which wander over the object from view to view. The distance of a sample to the surfaces of the
/// other views is the least that half of them agree on, and 0 where they do not agree on its sign.
/// It is compared with its robust deviation in the whole view, which holds all smooth errors of
/// calibration and poses. Where its mean square z^2 over 5 x 5 samples, at least half of them
/// compared, is beyond 4, the confidence is multiplied by 4 / z^2, equation (H16) of
/// docs/hybrid.md. No sample is removed.
///
/// Views need poses; `pairs` tells which views see the same surface, by their indices. A view says
/// nothing of samples that it sees steeply or resolves less than half as finely. Entries are in the
/// order of `views`. The same for any number of `threads`; 0: one per core. Only error:
/// kInterrupted, and the views are as they were.
Result<std::vector<ViewConsistency>> weigh_by_consistency(
    const std::vector<registration::PairFit>& pairs, int threads, std::vector<RangeView>& views,
    const Progress& progress = {});

}  // namespace relief::reconstruction
