#pragma once

#include <string>
#include <vector>

#include "apps/reports/html/report_figures.h"

namespace relief {

/// What a reader should do about a view.
enum class ViewGrade {
  kGood,
  kCheck,   ///< It is in the model, but something about it is weak.
  kRescan,  ///< It is not in the model, or its data contradict each other.
};
const char* to_string(ViewGrade grade);

struct GradedView {
  std::string name;
  ViewGrade grade = ViewGrade::kGood;
  std::vector<std::string> reasons;  ///< Sentences; none for a good view.
  std::size_t firm_pairs = 0;        ///< Pairs that determine its pose by themselves.
};

/// All views of the report in its order, graded by what its sections say:
/// - rescan: not aligned, or its ranges and normals contradict each other;
/// - check: its pose is not verified, no pair with another view is firm, the others contradict a
///   twentieth of its compared samples, or it was not refined although it has normals.
std::vector<GradedView> grade_views(const ReportFigures& report);

}  // namespace relief
