#pragma once

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "scan/grid/range_noise.h"

namespace relief::registration {

/// What each sample counts for in alignment: its confidence, or, where deviations are known, which
/// have the confidence in them, the inverse of its variance relative to the view's median one.
/// Without deviations, samples in regions whose ranges are noisier than the typical one (`ranges`)
/// count by the inverse of their variance, times their confidence; smoother ones count no more than
/// typical ones, lest few of them hold the pose alone. Empty: the confidence. So, too, for refined
/// views: neighbours share their errors, and sums of shared errors move poses, however small the
/// deviations of single samples are.
Grid<float> sample_weights(const RangeView& view, const RangeNoise& ranges);

}  // namespace relief::registration
