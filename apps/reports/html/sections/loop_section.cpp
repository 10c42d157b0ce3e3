#include "apps/reports/html/sections/loop_section.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "apps/reports/html/html_text.h"

namespace relief {

namespace {

constexpr std::size_t kMostLoops = 200;  // Rows of the table.

// Beyond, noise hardly explains a loop: its length has up to six components, of which none may be
// three deviations long by chance.
constexpr double kUnexplained = 3.0;

std::string views_on(const ReportFigures& report, const std::string& loop) {
  std::string names;
  for (const std::string& view : report.entries(loop + "/views"))
    names += (names.empty() ? "" : " – ") + escape_html(report.text(view));
  return names;
}

std::string loop_row(const ReportFigures& report, const std::string& loop) {
  const bool unexplained = report.number(loop + "/ratio").value_or(0.0) > kUnexplained;
  std::string html = fmt::format("<tr><th scope=\"row\">{}</th>", views_on(report, loop));
  html += fmt::format("<td{}>{}</td>", unexplained ? " class=\"rescan\"" : "",
                      report.shown(loop + "/ratio"));
  for (const char* key : {"/length", "/length_std", "/angle_deg", "/angle_std_deg"})
    html += "<td>" + report.shown(loop + key) + "</td>";
  return html + "</tr>\n";
}

std::string loops_in_words(const ReportContent& content, const std::vector<std::string>& loops) {
  const ReportFigures& report = content.report;
  const auto unexplained = std::count_if(loops.begin(), loops.end(), [&](const auto& loop) {
    return report.number(loop + "/ratio").value_or(0.0) > kUnexplained;
  });
  const std::string worst =
      fmt::format("The worst one ({}) misses by {}, {} times what noise makes expect.",
                  views_on(report, loops.front()),
                  report.shown(loops.front() + "/length", Rounding::kThreeDigits, content.unit),
                  report.shown(loops.front() + "/ratio"));
  if (unexplained == 0)
    return "<p>All loops close as well as noise allows: the pairs agree with each other. " + worst +
           "</p>\n";
  return fmt::format(
      "<p>{} of {} loops miss by more than {:.0f} times what noise makes expect: something else "
      "than noise bends a view, as a sensor that is not calibrated does, or an object that moved, "
      "or a pair is wrong. {}</p>\n",
      unexplained, loops.size(), kUnexplained, worst);
}

std::string loop_table(const ReportContent& content, const std::vector<std::string>& loops) {
  std::string html = fmt::format(
      "<table><thead><tr><th>Loop of views</th><th>Times the expected</th><th>Missed by [{0}]</th>"
      "<th>Expected [{0}]</th><th>Turned by [°]</th><th>Expected [°]</th></tr></thead><tbody>\n",
      escape_html(content.unit));
  for (std::size_t i = 0; i < std::min(loops.size(), kMostLoops); ++i)
    html += loop_row(content.report, loops[i]);
  html = scrolling_region("Table of loops", html + "</tbody></table>");
  if (loops.size() > kMostLoops)
    html +=
        fmt::format("<p>{} loops that close better are left out here; report.json has them.</p>\n",
                    loops.size() - kMostLoops);
  return fmt::format("<details><summary>All {} loops, the worst first</summary>\n{}</details>\n",
                     loops.size(), html);
}

}  // namespace

std::string loop_closures(const ReportContent& content) {
  const auto loops = content.report.entries(content.report.alignment() + "/loops");
  if (loops.empty()) return "";
  return "<h3>Loop closure</h3>\n" + loops_in_words(content, loops) +
         "<p>Each pair alone has a motion that fits it best. Composed around a loop of views, "
         "these "
         "motions should end where they began. What they miss by is given for points as far from "
         "the middle of the views as these reach, and as an angle.</p>\n" +
         loop_table(content, loops);
}

}  // namespace relief
