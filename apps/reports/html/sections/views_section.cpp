#include <algorithm>

#include <fmt/format.h>

#include "apps/reports/html/html_text.h"
#include "apps/reports/html/report_content.h"
#include "apps/reports/html/sections/spectrum_plot.h"

namespace relief {

namespace {

// Where the sections of the report speak of one view; empty where they do not.
struct ViewEntries {
  std::string alignment, consistency, refinement;
};

ViewEntries entries_of(const ReportFigures& report, const std::string& name) {
  return {report.entry_of(report.alignment() + "/views", name),
          report.entry_of("/compare/views", name), report.entry_of("/refine/views", name)};
}

std::string badge(ViewGrade grade) {
  return fmt::format(R"(<span class="badge {0}">{0}</span>)", to_string(grade));
}

std::string cell(const std::string& html) { return "<td>" + html + "</td>"; }

std::string row(const ReportContent& content, const GradedView& view) {
  const ReportFigures& report = content.report;
  const ViewEntries at = entries_of(report, view.name);
  const auto number = [&](const std::string& entry, const char* key, Rounding rounding) {
    return cell(entry.empty() ? "–" : report.shown(entry + key, rounding));
  };
  return fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td>{}{}{}{}{}{}{}{}{}</tr>\n",
                     escape_html(view.name), badge(view.grade),
                     cell(std::to_string(view.firm_pairs)),
                     number(at.refinement, "/sigma_position", Rounding::kThreeDigits),
                     number(at.refinement, "/sigma_normal_deg", Rounding::kThreeDigits),
                     number(at.refinement, "/normal_bias_deg", Rounding::kThreeDigits),
                     number(at.refinement, "/rms_change", Rounding::kThreeDigits),
                     number(at.refinement, "/median_deviation", Rounding::kThreeDigits),
                     number(at.refinement, "/flying_samples", Rounding::kCount),
                     number(at.refinement, "/filled_samples", Rounding::kCount),
                     number(at.consistency, "/samples_contradicted", Rounding::kCount));
}

std::string table(const ReportContent& content) {
  const std::string unit = escape_html(content.unit);
  std::string html = fmt::format(
      "<table><thead><tr>"
      "<th>View</th><th>Grade</th><th>Firm pairs</th>"
      "<th>Noise of ranges [{0}]</th><th>Noise of normals [°]</th><th>Normal bias [°]</th>"
      "<th>Moved by refining [{0}]</th><th>Expected error after [{0}]</th>"
      "<th>Flying samples left out</th><th>Samples filled in gaps</th>"
      "<th>Samples contradicted</th></tr></thead><tbody>\n",
      unit);
  for (const GradedView& view : content.views) html += row(content, view);
  return scrolling_region("Table of views", html + "</tbody></table>");
}

std::string noise_in_words(const ReportContent& content, const std::string& entry) {
  const ReportFigures& report = content.report;
  if (report.number(entry + "/sigma_position").value_or(0.0) <= 0.0) return {};
  std::string html =
      fmt::format("<p>Its ranges scatter by {} (standard deviation).",
                  report.shown(entry + "/sigma_position", Rounding::kThreeDigits, content.unit));
  if (report.number(entry + "/sigma_normal_deg").value_or(0.0) > 0.0)
    html += fmt::format(" Its normals scatter by {}°, and a slow error of {}° was found in them.",
                        report.shown(entry + "/sigma_normal_deg"),
                        report.shown(entry + "/normal_bias_deg"));
  return html + "</p>\n";
}

std::string refinement_in_words(const ReportContent& content, const std::string& entry) {
  const ReportFigures& report = content.report;
  if (report.text(entry + "/status") != "refined")
    return fmt::format("<p>It stays as measured: {}.</p>\n",
                       escape_html(report.text(entry + "/status")));
  return fmt::format(
      "<p>Refining moved {} samples by {} RMS, in {} rounds with {} steps of the solver "
      "({}&nbsp;s); "
      "positions weigh {} (λ) against normals. {} samples kept their range.</p>\n",
      report.shown(entry + "/samples_refined", Rounding::kCount),
      report.shown(entry + "/rms_change", Rounding::kThreeDigits, content.unit),
      report.shown(entry + "/rounds", Rounding::kCount),
      report.shown(entry + "/iterations", Rounding::kCount), report.shown(entry + "/seconds"),
      report.shown(entry + "/lambda"), report.shown(entry + "/samples_kept", Rounding::kCount));
}

std::string left_out_in_words(const ReportContent& content, const ViewEntries& at) {
  const ReportFigures& report = content.report;
  std::string html;
  if (!at.refinement.empty())
    html += fmt::format(
        "<p>{} flying samples, which lie on no surface, were left out. {} samples in small gaps "
        "were filled.</p>\n",
        report.shown(at.refinement + "/flying_samples", Rounding::kCount),
        report.shown(at.refinement + "/filled_samples", Rounding::kCount));
  if (!at.consistency.empty())
    html += fmt::format(
        "<p>Of {} samples that two other views or more measured, {} are contradicted and count "
        "less. The typical distance to the other surfaces is {}.</p>\n",
        report.shown(at.consistency + "/samples_compared", Rounding::kCount),
        report.shown(at.consistency + "/samples_contradicted", Rounding::kCount),
        report.shown(at.consistency + "/deviation", Rounding::kThreeDigits, content.unit));
  return html;
}

std::string pictures_of_view(const ReportContent& content, const std::string& name) {
  const auto pictures = content.view_pictures.find(name);
  if (pictures == content.view_pictures.end()) return "";
  std::string html = "<div class=\"pictures pairs\">\n";
  for (const ReportPicture& picture : pictures->second) html += picture_figure(picture);
  return html + "</div>\n";
}

std::string details(const ReportContent& content, const GradedView& view) {
  const ViewEntries at = entries_of(content.report, view.name);
  // The first view shows what there is to see.
  const bool opened = view.grade == ViewGrade::kRescan || &view == &content.views.front();
  std::string html = fmt::format("<details{}><summary>{} {}</summary>\n", opened ? " open" : "",
                                 escape_html(view.name), badge(view.grade));
  for (const std::string& reason : view.reasons) html += "<p>" + escape_html(reason) + "</p>\n";
  if (!at.refinement.empty())
    html += noise_in_words(content, at.refinement) + refinement_in_words(content, at.refinement);
  html += left_out_in_words(content, at);
  html += pictures_of_view(content, view.name);
  if (!at.refinement.empty()) html += spectrum_of_view(content, at.refinement);
  return html + "</details>\n";
}

std::string grades_in_words(const ReportContent& content) {
  const auto of = [&](ViewGrade grade) {
    return std::count_if(content.views.begin(), content.views.end(),
                         [&](const GradedView& view) { return view.grade == grade; });
  };
  const auto check = of(ViewGrade::kCheck), rescan = of(ViewGrade::kRescan);
  if (check + rescan == 0)
    return fmt::format("<p>Nothing speaks against any of the {} views.</p>\n",
                       content.views.size());
  return fmt::format(
      "<p>Of {} views {} {} to be checked and {} to be scanned again; below each says why.</p>\n",
      content.views.size(), check, check == 1 ? "is" : "are", rescan);
}

}  // namespace

std::string views_section(const ReportContent& content) {
  if (content.views.empty()) return "";
  std::string html = "<section id=\"views\"><h2>Views</h2>\n" + grades_in_words(content) +
                     table(content) + "<h3>Each view in words</h3>\n<div class=\"views\">\n";
  for (const GradedView& view : content.views) html += details(content, view);
  return html + "</div></section>\n";
}

}  // namespace relief
