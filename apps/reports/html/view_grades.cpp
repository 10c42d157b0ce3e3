#include "apps/reports/html/view_grades.h"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

namespace relief {

namespace {

constexpr double kManyContradicted = 0.05;

void lower(GradedView& view, ViewGrade grade, std::string reason) {
  view.grade = std::max(view.grade, grade);
  view.reasons.push_back(std::move(reason));
}

std::string because(const std::string& reason) {
  return reason.empty() ? "." : ": " + reason + ".";
}

void grade_pose(const ReportFigures& report, GradedView& view) {
  const std::string entry = report.entry_of(report.alignment() + "/views", view.name);
  if (entry.empty()) return;
  const std::string reason = report.text(entry + "/reason");
  if (!report.truth(entry + "/aligned").value_or(true))
    lower(view, ViewGrade::kRescan, "It fits nowhere and is not in the model" + because(reason));
  else if (report.text(entry + "/status") == "unverified")
    lower(view, ViewGrade::kCheck, "Nothing confirms its pose" + because(reason));
}

void grade_pairs(const ReportFigures& report, GradedView& view) {
  if (report.size(report.alignment() + "/views") > 1 && view.firm_pairs == 0 &&
      view.grade != ViewGrade::kRescan)
    lower(
        view, ViewGrade::kCheck,
        "No other view determines its pose by itself: a view between it and its neighbours helps.");
}

void grade_consistency(const ReportFigures& report, GradedView& view) {
  const std::string entry = report.entry_of("/compare/views", view.name);
  const double compared = report.number(entry + "/samples_compared").value_or(0.0);
  const double contradicted = report.number(entry + "/samples_contradicted").value_or(0.0);
  if (entry.empty() || compared <= 0.0 || contradicted < kManyContradicted * compared) return;
  lower(view, ViewGrade::kCheck,
        fmt::format("Other views contradict {:.0f} % of its compared samples: look for highlights "
                    "and for parts that moved.",
                    100.0 * contradicted / compared));
}

void grade_refinement(const ReportFigures& report, GradedView& view) {
  const std::string entry = report.entry_of("/refine/views", view.name);
  const std::string status = entry.empty() ? "refined" : report.text(entry + "/status");
  const std::set<std::string> harmless = {"refined", "no normals", ""};
  if (harmless.contains(status)) return;
  if (status.find("contradict") != std::string::npos)
    lower(view, ViewGrade::kRescan,
          "Its ranges and normals contradict each other: check the axes of its normals.");
  else
    lower(view, ViewGrade::kCheck, "It was not refined: " + status + ".");
}

using FirmPairs = std::map<std::string, std::size_t>;

FirmPairs count_firm_pairs(const ReportFigures& report) {
  FirmPairs count;
  for (const std::string& pair : report.entries(report.alignment() + "/pairs")) {
    if (report.text(pair + "/grade") != "firm") continue;
    ++count[report.text(pair + "/a")];
    ++count[report.text(pair + "/b")];
  }
  return count;
}

}  // namespace

const char* to_string(ViewGrade grade) {
  switch (grade) {
    case ViewGrade::kGood:
      return "good";
    case ViewGrade::kCheck:
      return "check";
    case ViewGrade::kRescan:
      return "rescan";
  }
  return "";
}

std::vector<GradedView> grade_views(const ReportFigures& report) {
  std::string list = report.alignment() + "/views";
  if (report.size(list) == 0) list = "/refine/views";
  const FirmPairs firm_pairs = count_firm_pairs(report);
  std::vector<GradedView> views;
  for (const std::string& entry : report.entries(list)) {
    GradedView& view = views.emplace_back();
    view.name = report.text(entry + "/name");
    const auto firm = firm_pairs.find(view.name);
    view.firm_pairs = firm == firm_pairs.end() ? 0 : firm->second;
    grade_pose(report, view);
    grade_pairs(report, view);
    grade_consistency(report, view);
    grade_refinement(report, view);
  }
  return views;
}

}  // namespace relief
