#pragma once

#include <string>
#include <vector>

#include "apps/reports/report.h"
#include "relief/hybrid/refine_view.h"

namespace relief {

/// The section `refine` of the report, but for its seconds: what refining did to each of `views`,
/// which are the refined ones.
Json refinement_report(const std::vector<hybrid::RefineSummary>& refinements,
                       const std::vector<RangeView>& views);

/// Logs the same, and a line on all of them, `seconds` after the start.
void log_refinement(const std::vector<hybrid::RefineSummary>& refinements,
                    const std::vector<RangeView>& views, const std::string& unit, double seconds);

}  // namespace relief
