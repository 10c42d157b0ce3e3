#pragma once

#include <vector>

#include "fusion/views/range_errors.h"
#include "fusion/views/view_sampler.h"

namespace relief::fusion {

/// What the other views say of one.
struct ViewContradiction {
  /// Of its samples that other views judge, the part that these outvote: at least two views, and
  /// twice as many as agree with the sample, it included, have their surface elsewhere on one side
  /// of it.
  double outvoted = 0.0;
  /// Whether more than a tenth are outvoted, and more than twice as many as of the typical view.
  /// Stray samples, flying pixels and moving parts of right views are fewer; errors that a sensor
  /// has in all views are in all of them.
  bool contradicted = false;
};

/// Judges each view by up to a thousand of its samples. A surface is elsewhere when it is farther
/// off than the sample spacing and four standard deviations: of what `errors` tells of two views,
/// and of the noise that both show. Views with too few judged samples are not contradicted, nor are
/// any where errors are unknown. Copies of a view count as one. The order of the views does not
/// matter.
std::vector<ViewContradiction> judge_views(const std::vector<ViewSampler>& views,
                                           const RangeErrors& errors);

}  // namespace relief::fusion
