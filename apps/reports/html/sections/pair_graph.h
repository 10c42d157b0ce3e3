#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "apps/reports/html/report_content.h"

namespace relief {

/// A pair of the alignment whose views are both in the page.
struct PlacedPair {
  std::size_t a, b;   ///< Positions in ReportContent::views.
  std::string place;  ///< Its entry in the report.
};
std::vector<PlacedPair> placed_pairs(const ReportContent& content);

/// The views on a circle, joined where they are a pair, as <figure> with an inline SVG.
std::string pair_graph(const ReportContent& content);

}  // namespace relief
