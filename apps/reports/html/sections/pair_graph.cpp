#include "apps/reports/html/sections/pair_graph.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "apps/reports/html/html_text.h"

namespace relief {

namespace {

constexpr double kRadius = 170.0;  // Of the circle, in the units of the drawing.
constexpr std::size_t kMostLabels = 48;

Eigen::Vector2d place(std::size_t i, std::size_t count, double radius) {
  const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
  return {radius * std::sin(angle), -radius * std::cos(angle)};
}

std::string edge(const ReportContent& content, const std::string& pair, const Eigen::Vector2d& a,
                 const Eigen::Vector2d& b) {
  const ReportFigures& report = content.report;
  const double overlap = report.number(pair + "/overlap").value_or(0.0);
  return fmt::format(
      R"(<line class="edge {}" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke-width="{:.1f}">)"
      "<title>{} – {}: {}, residual {} {}, overlap {:.0f} %</title></line>\n",
      escape_html(report.text(pair + "/grade")), a.x(), a.y(), b.x(), b.y(),
      0.6 + 6.0 * std::clamp(overlap, 0.0, 1.0), escape_html(report.text(pair + "/a")),
      escape_html(report.text(pair + "/b")), escape_html(report.text(pair + "/grade")),
      three_digits(report.number(pair + "/rms").value_or(0.0)), escape_html(content.unit),
      100.0 * overlap);
}

std::string edges(const ReportContent& content) {
  const std::size_t count = content.views.size();
  std::string svg;
  for (const PlacedPair& pair : placed_pairs(content))
    svg += edge(content, pair.place, place(pair.a, count, kRadius), place(pair.b, count, kRadius));
  return svg;
}

std::string node(const GradedView& view, std::size_t i, std::size_t count) {
  const Eigen::Vector2d centre = place(i, count, kRadius);
  std::string svg = fmt::format(
      R"(<circle class="node {0}" cx="{1:.1f}" cy="{2:.1f}" r="{3}"><title>{4}: {0}</title></circle>)"
      "\n",
      to_string(view.grade), centre.x(), centre.y(), count <= kMostLabels ? 7 : 3,
      escape_html(view.name));
  if (count > kMostLabels) return svg;
  const Eigen::Vector2d label = place(i, count, kRadius + 16.0);
  const char* anchor = label.x() > 20.0 ? "start" : label.x() < -20.0 ? "end" : "middle";
  return svg + fmt::format(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>)"
                           "\n",
                           label.x(), label.y() + 4.0, anchor, escape_html(view.name));
}

}  // namespace

std::vector<PlacedPair> placed_pairs(const ReportContent& content) {
  std::map<std::string, std::size_t> position;
  for (std::size_t i = 0; i < content.views.size(); ++i) position[content.views[i].name] = i;
  std::vector<PlacedPair> placed;
  for (const std::string& pair : content.report.entries(content.report.alignment() + "/pairs")) {
    const auto a = position.find(content.report.text(pair + "/a"));
    const auto b = position.find(content.report.text(pair + "/b"));
    if (a != position.end() && b != position.end()) placed.push_back({a->second, b->second, pair});
  }
  return placed;
}

std::string pair_graph(const ReportContent& content) {
  std::string svg = edges(content);
  for (std::size_t i = 0; i < content.views.size(); ++i)
    svg += node(content.views[i], i, content.views.size());
  return "<figure class=\"graph\"><svg viewBox=\"-270 -205 540 410\" role=\"img\" "
         "aria-label=\"Graph "
         "of views and pairs\">\n" +
         svg +
         "</svg>\n<figcaption>Dots are views, lines are pairs. The wider a line, the larger the "
         "overlap. <span class=\"key firm\">firm</span> pairs determine the motion between both "
         "views; <span class=\"key degenerate\">degenerate</span> ones leave directions free; "
         "<span "
         "class=\"key thin\">thin</span> ones share little; <span class=\"key "
         "misfit\">misfit</span> "
         "ones do not fit and are not used.</figcaption></figure>\n";
}

}  // namespace relief
