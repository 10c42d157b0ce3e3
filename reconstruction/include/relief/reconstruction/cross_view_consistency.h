#pragma once

#include <cstddef>
#include <vector>

#include "relief/registration/pair_fit.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::reconstruction {

/// What the other views say of the ranges of one view.
struct ViewConsistency {
  std::size_t compared = 0;      ///< Samples that two other views or more measured as well.
  std::size_t contradicted = 0;  ///< Those that count less now.
  std::size_t corrected = 0;     ///< Those whose range has changed, too.
  /// Robust standard deviation of the distance to the others' surfaces [unit]; 0: none compared.
  double deviation = 0.0;
};

struct CrossViewOptions {
  bool correct = true;  ///< Whether ranges change; else they only count less.
};

/// Lowers the confidence of patches where one view's ranges are wrong: in highlights, for instance,
/// which wander over the object from view to view. The distance of a sample to the surfaces of the
/// other views is the least that half of them agree on, and 0 where they do not agree on its sign.
/// It is compared with its robust deviation in the whole view, which holds all smooth errors of
/// calibration and poses. Where its mean square z^2 over 5 x 5 samples, at least half of them
/// compared, is beyond 4, the confidence is multiplied by 4 / z^2, equation (H16) of
/// docs/hybrid.md.
///
/// Samples of such patches that are themselves more than two deviations off are moved along their
/// rays to the median of the other views' surfaces, where this halves the squared steps between
/// them and beside them. Wrong ranges often stand apart like other surfaces do, and confidence
/// alone would not connect them. No sample is removed.
///
/// Views need poses; `pairs` tells which views see the same surface, by their indices. A view says
/// nothing of samples that it sees steeply or resolves less than half as finely. Entries are in the
/// order of `views`. Only error: kInterrupted, and the views are as they were.
Result<std::vector<ViewConsistency>> weigh_by_consistency(
    const std::vector<registration::PairFit>& pairs, const CrossViewOptions& options,
    std::vector<RangeView>& views, const Context& context = {});

}  // namespace relief::reconstruction
