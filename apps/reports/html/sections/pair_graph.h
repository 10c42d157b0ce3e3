#pragma once

#include <string>

#include "apps/reports/html/report_content.h"

namespace relief {

/// The views on a circle, joined where they are a pair, as <figure> with an inline SVG.
std::string pair_graph(const ReportContent& content);

}  // namespace relief
