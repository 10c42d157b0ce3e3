#pragma once

#include <string>
#include <vector>

#include "apps/reports/report.h"
#include "relief/reconstruction/cross_view_consistency.h"

namespace relief {

/// The section `compare` of the report, but for its seconds: what other views say of the ranges of
/// each of `views`.
Json consistency_report(const std::vector<reconstruction::ViewConsistency>& consistency,
                        const std::vector<RangeView>& views);

/// Names the views that others contradict.
void log_consistency(const std::vector<reconstruction::ViewConsistency>& consistency,
                     const std::vector<RangeView>& views, const std::string& unit, double seconds);

}  // namespace relief
