#pragma once

#include <cstddef>
#include <vector>

#include "fusion/views/view_sampler.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::fusion {

/// The view without the samples that speak of what other views measured: within eight sample
/// spacings of the surface of one, in space that one saw empty, or seen through what one measured.
/// Nor has it samples that make no surface. `sampler` is of the view, `others` are not. Errors:
/// those of ViewProjection.
Result<RangeView> unshared_samples(const RangeView& view, const ViewSampler& sampler,
                                   const std::vector<const ViewSampler*>& others);

}  // namespace relief::fusion
