#include <fmt/format.h>

#include "apps/reports/html/html_text.h"
#include "apps/reports/html/report_content.h"

namespace relief {

namespace {

std::string text_entry(const ReportFigures& report, const char* term, const char* place) {
  const std::string text = report.text(place);
  return text.empty() ? "" : list_entry(term, escape_html(text));
}

std::string options(const ReportFigures& report) {
  const Json* given = report.find("/run/options");
  if (!given || !given->is_object()) return "";
  std::string list;
  for (const auto& [name, value] : given->items())
    list += fmt::format("<code>{} {}</code> ", escape_html(name),
                        escape_html(value.is_string() ? value.get<std::string>() : value.dump()));
  return list_entry("Options given", list.empty() ? "none: all have their defaults" : list);
}

std::string times(const ReportFigures& report) {
  struct Stage {
    const char *section, *name;
  };
  constexpr Stage kStages[] = {{"/align", "Time to align"},
                               {"/calibrate", "Time to calibrate sensors"},
                               {"/compare", "Time to compare views"},
                               {"/refine", "Time to refine"},
                               {"/align_again", "Time to align again"},
                               {"/merge", "Time to merge"}};
  std::string html;
  for (const Stage& stage : kStages) {
    const std::string place = std::string(stage.section) + "/seconds";
    if (report.number(place))
      html += list_entry(stage.name, report.shown(place, Rounding::kThreeDigits, "s"));
  }
  return html;
}

std::string memory(const ReportFigures& report) {
  if (!report.number("/merge/peak_memory_mb")) return "";
  return list_entry("Largest memory",
                    report.shown("/merge/peak_memory_mb", Rounding::kThreeDigits, "MB"));
}

}  // namespace

std::string provenance_section(const ReportContent& content) {
  const ReportFigures& report = content.report;
  return "<section id=\"provenance\"><h2>Provenance</h2>\n"
         "<p>What the model was made from, and how.</p>\n<dl>" +
         text_entry(report, "Version of relief", "/relief") +
         text_entry(report, "Input", "/run/input") + options(report) + times(report) +
         memory(report) + "</dl></section>\n";
}

}  // namespace relief
