#include <algorithm>

#include <fmt/format.h>

#include "apps/reports/html/html_text.h"
#include "apps/reports/html/report_content.h"

namespace relief {

namespace {

struct Bar {
  double value = 0.0;
  std::string title;  ///< Plain text.
  std::string label;  ///< Below the bar; may be empty.
};

std::string bar_chart(const std::vector<Bar>& bars, const std::string& caption,
                      const std::string& axis) {
  constexpr double kWidth = 480.0, kHeight = 160.0;
  double most = 0.0;
  for (const Bar& bar : bars) most = std::max(most, bar.value);
  const double step = kWidth / static_cast<double>(bars.size());
  std::string svg;
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const double x = step * static_cast<double>(i);
    const double height = most > 0.0 ? kHeight * bars[i].value / most : 0.0;
    svg += fmt::format(
        R"(<rect class="bar" x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}"><title>{}</title></rect>)"
        "\n",
        x + 0.5, kHeight - height, step - 1.0, height, escape_html(bars[i].title));
    if (!bars[i].label.empty())
      svg += fmt::format(R"(<text x="{:.1f}" y="176" text-anchor="middle">{}</text>)"
                         "\n",
                         x + 0.5 * step, escape_html(bars[i].label));
  }
  return fmt::format(
      "<figure><figcaption>{}</figcaption><svg viewBox=\"-12 -6 504 212\" role=\"img\" "
      "aria-label=\"{}\">\n{}<line class=\"axis\" x1=\"0\" y1=\"160\" x2=\"480\" y2=\"160\"/><text "
      "x=\"240\" y=\"198\" text-anchor=\"middle\">{}</text></svg></figure>\n",
      escape_html(caption), escape_html(caption), svg, escape_html(axis));
}

std::string error_chart(const Histogram& histogram, const std::string& unit) {
  std::vector<Bar> bars;
  const std::size_t count = histogram.counts.size();
  const double step = (histogram.high - histogram.low) / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double low = histogram.low + step * static_cast<double>(i);
    const std::string to = i + 1 == count ? "and more" : "to " + three_digits(low + step);
    bars.push_back({static_cast<double>(histogram.counts[i]),
                    fmt::format("{} {} {}: {} vertices", three_digits(low), to, unit,
                                grouped(histogram.counts[i])),
                    i % 10 == 0 ? three_digits(low) : ""});
  }
  return bar_chart(bars, "Expected error of the measured vertices",
                   "expected error [" + unit + "]");
}

std::string views_chart(const std::vector<std::size_t>& counts) {
  constexpr std::size_t kMost = 24;  // All further ones are the last bar.
  std::vector<Bar> bars(std::min(counts.size(), kMost + 1));
  for (std::size_t i = 0; i < counts.size(); ++i)
    bars[std::min(i, kMost)].value += static_cast<double>(counts[i]);
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const std::string views =
        std::to_string(i) + (i == kMost && counts.size() > kMost + 1 ? "+" : "");
    bars[i].label = views;
    bars[i].title = fmt::format("{} views: {} vertices", views,
                                grouped(static_cast<std::uint64_t>(bars[i].value)));
  }
  return bar_chart(bars, "Number of views that measured a vertex", "views (0: filled)");
}

std::string yes_or_no(const ReportFigures& report, const char* place) {
  const auto truth = report.truth(place);
  return !truth ? "–" : *truth ? "yes" : "no";
}

std::string size_entries(const ReportContent& content) {
  const ReportFigures& report = content.report;
  const std::string unit = escape_html(content.unit);
  std::string html = list_entry("Vertices", report.shown("/merge/vertices", Rounding::kCount)) +
                     list_entry("Faces", report.shown("/merge/faces", Rounding::kCount)) +
                     list_entry("Volume", report.shown("/merge/volume", Rounding::kThreeDigits,
                                                       content.unit + "³"));
  if (content.model) {
    const double filled = report.number("/merge/filled_area_fraction").value_or(0.0);
    html += list_entry("Area", three_digits(content.model->area) + "&nbsp;" + unit + "²");
    html += list_entry("Area measured",
                       three_digits(content.model->area * (1.0 - filled)) + "&nbsp;" + unit + "²");
  }
  return html +
         list_entry("Area filled",
                    report.shown("/merge/filled_area_fraction", Rounding::kPercent)) +
         list_entry("Voxel size",
                    report.shown("/merge/voxel_size", Rounding::kThreeDigits, content.unit)) +
         list_entry("Truncation",
                    report.shown("/merge/truncation", Rounding::kThreeDigits, content.unit));
}

// Only where they were looked for.
std::string self_intersections(const ReportFigures& report) {
  if (!report.number("/merge/self_intersections")) return "";
  return list_entry("Faces that intersect, pairs",
                    report.shown("/merge/self_intersections", Rounding::kCount));
}

std::string topology_entries(const ReportFigures& report) {
  return list_entry("Watertight", yes_or_no(report, "/merge/watertight")) +
         list_entry("Manifold edges", yes_or_no(report, "/merge/manifold_edges")) +
         list_entry("Manifold vertices", yes_or_no(report, "/merge/manifold_vertices")) +
         list_entry("Oriented", yes_or_no(report, "/merge/oriented")) +
         list_entry("Boundary edges", report.shown("/merge/boundary_edges", Rounding::kCount)) +
         self_intersections(report) +
         list_entry("Components", report.shown("/merge/components", Rounding::kCount)) +
         list_entry("Genus (handles)", report.shown("/merge/genus", Rounding::kCount)) +
         list_entry("Components removed",
                    report.shown("/merge/components_removed", Rounding::kCount));
}

std::string polish_entries(const ReportContent& content) {
  const ReportFigures& report = content.report;
  if (!report.find("/merge/polish")) return "";
  const std::string at = "/merge/polish";
  return "<h3>Polishing</h3>\n<dl>" +
         list_entry("Result", escape_html(report.text(at + "/status"))) +
         list_entry("Vertices with normal",
                    report.shown(at + "/vertices_with_normal", Rounding::kCount)) +
         list_entry("Scatter of a view's normals", report.shown(at + "/sigma_view_deg") + "°") +
         list_entry("Vertices moved, RMS",
                    report.shown(at + "/rms_move", Rounding::kThreeDigits, content.unit)) +
         list_entry("At most",
                    report.shown(at + "/max_move", Rounding::kThreeDigits, content.unit)) +
         list_entry("Vertices held back", report.shown(at + "/vertices_damped", Rounding::kCount)) +
         "</dl>\n";
}

std::string charts(const ReportContent& content) {
  if (!content.model) return "";
  std::string html;
  if (content.model->expected_error)
    html += error_chart(*content.model->expected_error, content.unit);
  if (!content.model->vertices_by_views.empty())
    html += views_chart(content.model->vertices_by_views);
  return html.empty() ? "" : "<div class=\"columns\">\n" + html + "</div>\n";
}

// What the check of the mesh certifies, and how much of it is evidence.
std::string model_in_words(const ReportContent& content) {
  const ReportFigures& report = content.report;
  const auto holds = [&](const char* key) {
    return report.truth(std::string("/merge/") + key).value_or(false);
  };
  const bool manifold = holds("manifold_edges") && holds("manifold_vertices");
  const std::string topology =
      holds("watertight") ? manifold ? "The surface is closed, and every edge has two faces"
                                     : "The surface is closed"
                          : "The surface has holes";
  std::string html = fmt::format("<p>{}: its genus is {}, in {} {}.", topology,
                                 report.shown("/merge/genus", Rounding::kCount),
                                 report.shown("/merge/components", Rounding::kCount),
                                 report.number("/merge/components") == 1.0 ? "piece" : "pieces");
  if (report.number("/merge/filled_area_fraction"))
    html += fmt::format(" No view measured {} of its area, which is filled.",
                        report.shown("/merge/filled_area_fraction", Rounding::kPercent));
  return html + "</p>\n";
}

}  // namespace

std::string model_section(const ReportContent& content) {
  if (!content.report.find("/merge")) return "";
  return "<section id=\"model\"><h2>Model</h2>\n" + model_in_words(content) + charts(content) +
         "<div class=\"columns\"><div><h3>Size</h3>\n<dl>" + size_entries(content) +
         "</dl></div>\n<div><h3>Topology</h3>\n<dl>" + topology_entries(content.report) +
         "</dl></div>\n<div>" + polish_entries(content) + "</div></div></section>\n";
}

}  // namespace relief
