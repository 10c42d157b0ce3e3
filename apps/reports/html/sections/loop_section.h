#pragma once

#include <string>

#include "apps/reports/html/report_content.h"

namespace relief {

/// What the loops of the pairs say: a sentence, and a table with the worst first. Empty where the
/// report has no loops.
std::string loop_closures(const ReportContent& content);

}  // namespace relief
