#pragma once

#include <vector>

#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/scan_project.h"

namespace relief::evaluation {

/// A view and its truth, which outlive this.
struct ViewAndTruth {
  const RangeView* view = nullptr;
  const RangeView* truth = nullptr;
};

/// Each view of `result` with the true view of its name. kBadInput when there is none, or the two
/// differ in size or in their rays.
Result<std::vector<ViewAndTruth>> pair_views(const ScanProject& result, const ScanProject& truth);

/// Equation (E3): the signed distance between the two points of one ray [unit], positive when the
/// view's is farther away. Their ranges may be in different scales.
double depth_error(const ViewAndTruth& pair, int u, int v);

}  // namespace relief::evaluation
