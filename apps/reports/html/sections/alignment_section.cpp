#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "apps/reports/html/html_text.h"
#include "apps/reports/html/report_content.h"
#include "apps/reports/html/sections/loop_section.h"
#include "apps/reports/html/sections/pair_graph.h"
#include "scan/base/median.h"

namespace relief {

namespace {

constexpr std::size_t kLargestMatrix = 40;  // Views; more cells than a page can take.
constexpr std::size_t kMostPairs = 400;     // Rows of the table of pairs.

// The cells of the matrix, by the positions of both views.
using PairPlaces = std::map<std::pair<std::size_t, std::size_t>, std::string>;

PairPlaces places_of_pairs(const ReportContent& content) {
  PairPlaces places;
  for (const PlacedPair& pair : placed_pairs(content))
    places[std::minmax(pair.a, pair.b)] = pair.place;
  return places;
}

double median_residual(const ReportContent& content) {
  std::vector<double> residuals;
  for (const std::string& pair : content.report.entries(content.report.alignment() + "/pairs"))
    if (const auto rms = content.report.number(pair + "/rms")) residuals.push_back(*rms);
  return median(residuals);
}

// Colours go from the median of all pairs (cool) to twice that (hot).
int heat(double residual, double median) {
  if (median <= 0.0) return 0;
  return static_cast<int>(100.0 * std::clamp(residual / median - 0.5, 0.0, 1.5) / 1.5);
}

std::string residual_cell(const ReportContent& content, const std::string& pair, double median) {
  const auto rms = content.report.number(pair + "/rms");
  if (!rms) return "<td>–</td>";
  return fmt::format(R"(<td class="heat" style="--heat-share:{}%">{}</td>)", heat(*rms, median),
                     content.report.shown(pair + "/rms"));
}

std::string overlap_cell(const ReportContent& content, const std::string& pair) {
  const double overlap = content.report.number(pair + "/overlap").value_or(0.0);
  return fmt::format(R"(<td class="share" style="--share-part:{:.0f}%">{}</td>)",
                     100.0 * std::clamp(overlap, 0.0, 1.0),
                     content.report.shown(pair + "/overlap", Rounding::kPercent));
}

std::string matrix_row(const ReportContent& content, const PairPlaces& places, std::size_t row,
                       double median) {
  std::string html =
      fmt::format("<tr><th scope=\"row\">{}</th>", escape_html(content.views[row].name));
  for (std::size_t column = 0; column < content.views.size(); ++column) {
    const auto pair = places.find(std::minmax(row, column));
    if (row == column)
      html += "<td class=\"diagonal\"></td>";
    else if (pair == places.end())
      html += "<td></td>";
    else
      html += row < column ? residual_cell(content, pair->second, median)
                           : overlap_cell(content, pair->second);
  }
  return html + "</tr>\n";
}

std::string matrix(const ReportContent& content) {
  if (content.views.size() > kLargestMatrix)
    return fmt::format(
        "<p>The matrix of pairs is left out: {} views are more than {}. The table "
        "below has the pairs.</p>\n",
        content.views.size(), kLargestMatrix);
  const PairPlaces places = places_of_pairs(content);
  const double median = median_residual(content);
  std::string html = "<table class=\"matrix\"><thead><tr><td></td>";
  for (const GradedView& view : content.views)
    html += fmt::format("<th scope=\"col\">{}</th>", escape_html(view.name));
  html += "</tr></thead><tbody>\n";
  for (std::size_t row = 0; row < content.views.size(); ++row)
    html += matrix_row(content, places, row, median);
  return fmt::format(
             "<h3>Pairs of views</h3>\n<p>Above the diagonal: residual of the pair [{}]. The "
             "stronger the colour, the larger it is beside the median of {}. Below the diagonal: "
             "overlap.</p>\n",
             escape_html(content.unit), three_digits(median)) +
         scrolling_region("Matrix of pairs", html + "</tbody></table>");
}

std::string free_directions(const ReportFigures& report, const std::string& pair) {
  std::string text;
  for (const std::string& place : report.entries(pair + "/degenerate_directions"))
    text += (text.empty() ? "" : "; ") + report.text(place);
  return text;
}

// The largest residuals first.
std::vector<std::string> sorted_pairs(const ReportFigures& report) {
  std::vector<std::string> pairs = report.entries(report.alignment() + "/pairs");
  const auto residual = [&](const std::string& pair) {
    return report.number(pair + "/rms").value_or(0.0);
  };
  std::stable_sort(pairs.begin(), pairs.end(), [&](const std::string& a, const std::string& b) {
    return residual(a) > residual(b);
  });
  return pairs;
}

std::string pair_table(const ReportContent& content) {
  const ReportFigures& report = content.report;
  const std::vector<std::string> pairs = sorted_pairs(report);
  const std::size_t shown = std::min(pairs.size(), kMostPairs);
  std::string rows;
  for (std::size_t i = 0; i < shown; ++i) {
    const std::string& pair = pairs[i];
    rows += fmt::format(
        "<tr><th scope=\"row\">{} – {}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>"
        "</tr>\n",
        escape_html(report.text(pair + "/a")), escape_html(report.text(pair + "/b")),
        escape_html(report.text(pair + "/grade")), report.shown(pair + "/rms"),
        report.shown(pair + "/overlap", Rounding::kPercent),
        report.shown(pair + "/correspondences", Rounding::kCount),
        escape_html(free_directions(report, pair)));
  }
  const std::string head = fmt::format(
      "<table><thead><tr><th>Pair</th><th>Grade</th><th>Residual [{}]</th><th>Overlap</th>"
      "<th>Correspondences</th><th>Degenerate directions</th></tr></thead><tbody>\n",
      escape_html(content.unit));
  const std::string rest = shown < pairs.size()
                               ? fmt::format(
                                     "<p>{} pairs with smaller residuals are left out here; "
                                     "report.json has them.</p>\n",
                                     pairs.size() - shown)
                               : "";
  return fmt::format(
      "<details><summary>All {} pairs, the largest residual first</summary>\n{}{}"
      "</details>\n",
      pairs.size(), scrolling_region("Table of pairs", head + rows + "</tbody></table>"), rest);
}

std::string degenerate_directions(const ReportContent& content) {
  const ReportFigures& report = content.report;
  std::string items;
  for (const std::string& pair : sorted_pairs(report)) {
    const std::string free = free_directions(report, pair);
    if (free.empty()) continue;
    items += fmt::format("<li>{} – {}: {}</li>\n", escape_html(report.text(pair + "/a")),
                         escape_html(report.text(pair + "/b")), escape_html(free));
  }
  if (items.empty()) return "<p>Every pair determines its motion in all directions.</p>\n";
  return "<p>These pairs alone leave motions free; the other pairs of both views determine "
         "them:</p>\n<ul>" +
         items + "</ul>\n";
}

std::string deviations(const ReportContent& content) {
  const ReportFigures& report = content.report;
  std::string rows;
  for (const std::string& view : report.entries(report.alignment() + "/views")) {
    rows += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td>",
                        escape_html(report.text(view + "/name")),
                        escape_html(report.text(view + "/status")));
    for (int k = 0; k < 6; ++k)
      rows += fmt::format("<td>{}</td>", report.shown(view + "/pose_std/" + std::to_string(k)));
    rows += "</tr>\n";
  }
  const std::string head = fmt::format(
      "<table><thead><tr><th rowspan=\"2\">View</th><th rowspan=\"2\">Pose</th><th colspan=\"3\">"
      "Rotation about x, y, z [rad]</th><th colspan=\"3\">Translation along x, y, z [{}]</th></tr>"
      "</thead><tbody>\n",
      escape_html(content.unit));
  return "<h3>Standard deviations of the poses</h3>\n<p>A view whose pose is known, or that holds "
         "the others in place, has none.</p>\n" +
         scrolling_region("Standard deviations of the poses", head + rows + "</tbody></table>");
}

std::string introduction(const ReportContent& content) {
  const ReportFigures& report = content.report;
  const std::string section = report.alignment();
  const std::string termination = report.text(section + "/termination");
  const bool moves = report.truth(section + "/stands_still") == false &&
                     termination == "iteration limit" && report.number(section + "/last_motion");
  return fmt::format(
      "<p>{} The alignment {} after {} iterations, with a residual of {} RMS.{}</p>\n",
      section == "/align" ? "" : "These are the poses found on the refined views.",
      termination == "converged"         ? "converged"
      : termination == "iteration limit" ? "ended"
                                         : "ended (" + escape_html(termination) + ")",
      report.shown(section + "/iterations", Rounding::kCount),
      report.shown(section + "/rms", Rounding::kThreeDigits, content.unit),
      moves ? " The last one still moved views by up to " +
                  report.shown(section + "/last_motion", Rounding::kThreeDigits, content.unit) + "."
            : "");
}

}  // namespace

std::string alignment_section(const ReportContent& content) {
  const std::string section = content.report.alignment();
  if (content.report.size(section + "/views") == 0) return "";
  std::string html = "<section id=\"alignment\"><h2>Alignment</h2>\n" + introduction(content);
  if (content.report.size(section + "/pairs") > 0)
    html += pair_graph(content) + matrix(content) + pair_table(content) + loop_closures(content) +
            "<h3>Degenerate directions</h3>\n" + degenerate_directions(content);
  return html + deviations(content) + "</section>\n";
}

}  // namespace relief
