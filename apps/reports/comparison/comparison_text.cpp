#include <fmt/format.h>

#include "apps/reports/comparison/comparison_report.h"
#include "apps/reports/evaluation/evaluation_report.h"

namespace relief {

namespace {

std::string in_words(Quantity quantity, const std::optional<double>& value) {
  if (!value) return kNoFigure;
  switch (quantity) {
    case Quantity::kCount:
      return fmt::format("{:.0f}", *value);
    case Quantity::kTruth:
      return *value != 0.0 ? "yes" : "no";
    case Quantity::kFraction:
      return fmt::format("{:.3g} %", 100.0 * *value);
    default:
      return fmt::format("{:.4g}", *value);
  }
}

std::string signed_words(Quantity quantity, const std::optional<double>& value) {
  return (value && *value > 0.0 ? "+" : "") + in_words(quantity, value);
}

std::string number(const std::optional<double>& value) {
  return in_words(Quantity::kNumber, value);
}

std::string or_dash(const std::string& text) { return text.empty() ? kNoFigure : text; }

void print_side(const char* name, const RunSide& side) {
  fmt::print("{}: {}, relief {}{}\n", name, side.folder, or_dash(side.version),
             side.program.empty() ? "" : ", build " + side.program.substr(0, 12));
}

void print_options(const RunComparison& comparison) {
  if (comparison.options.empty()) {
    fmt::print("options: the same\n");
    return;
  }
  fmt::print("{:<34} {:>16} {:>16}\n", "options that differ", "A", "B");
  for (const ComparedOption& option : comparison.options)
    fmt::print("  {:<32} {:>16} {:>16}{}\n", option.name, option.a.value_or("default"),
               option.b.value_or("default"), option.changes_result ? "" : "  (changes no result)");
}

void print_figures(const RunComparison& comparison) {
  std::string group;
  for (const ComparedFigure& figure : comparison.figures) {
    if (!figure.a && !figure.b) continue;
    if (figure.group != group)
      fmt::print("{:<48} {:>12} {:>12} {:>12} {:>8}\n", figure.group, "A", "B", "difference",
                 "ratio");
    group = figure.group;
    const std::string unit = unit_of(figure.quantity, comparison.unit);
    fmt::print("  {:<46} {:>12} {:>12} {:>12} {:>8}\n",
               unit.empty() ? figure.title : figure.title + " [" + unit + "]",
               in_words(figure.quantity, figure.a), in_words(figure.quantity, figure.b),
               signed_words(figure.quantity, figure.difference()), number(figure.ratio()));
  }
}

std::string either(const std::string& a, const std::string& b) {
  return a == b ? or_dash(a) : or_dash(a) + " / " + or_dash(b);
}

void print_views(const RunComparison& comparison) {
  if (comparison.views.empty()) return;
  fmt::print("{:<18} {:<20} {:<24} {:>12} {:>12} {:>12} {:>12}\n", "views", "input", "status A / B",
             "turned [deg]", "moved [" + comparison.unit + "]", "deviation A", "deviation B");
  for (const ComparedView& view : comparison.views) {
    std::optional<double> turned, moved;
    if (view.pose) turned = view.pose->rotation_deg;
    if (view.pose) moved = view.pose->mean_displacement;
    fmt::print("  {:<16} {:<20} {:<24} {:>12} {:>12} {:>12} {:>12}\n", view.name,
               to_string(view.input), either(view.a.alignment, view.b.alignment), number(turned),
               number(moved), number(view.a.median_deviation), number(view.b.median_deviation));
  }
}

void print_frame(const RunComparison& comparison) {
  const FrameMotion& frame = comparison.frame;
  if (frame.views > 0)
    fmt::print(
        "B is in the frame of A by the poses of {} common views: turned {:.4g} deg, moved "
        "{:.4g} {}\n",
        frame.views, frame.rotation_deg, frame.shift, comparison.unit);
  else if (comparison.poses || comparison.models)
    fmt::print("the frames of A and B are taken as one\n");
  if (comparison.poses)
    fmt::print(
        "poses of B against A: displacement of the samples mean {:.4g}, worst view {:.4g} "
        "{}; rotation mean {:.4g}, max {:.4g} deg\n",
        comparison.poses->mean_displacement, comparison.poses->max_displacement, comparison.unit,
        comparison.poses->mean_rotation_deg, comparison.poses->max_rotation_deg);
}

}  // namespace

void print_tables(const RunComparison& comparison) {
  print_side("A", comparison.a);
  print_side("B", comparison.b);
  for (const std::string& note : comparison.notes) fmt::print("note: {}\n", note);
  print_options(comparison);
  print_figures(comparison);
  print_views(comparison);
  print_frame(comparison);
  if (comparison.models) print_table(comparison.models->distances, comparison.unit);
}

}  // namespace relief
