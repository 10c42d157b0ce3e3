#include "apps/reports/comparison/comparison_page.h"

#include <algorithm>

#include <fmt/format.h>

#include "apps/reports/comparison/comparison_report.h"
#include "apps/reports/html/html_text.h"
#include "apps/reports/html/page_frame.h"
#include "apps/version.h"

namespace relief {

namespace {

std::string cell(const std::string& html) { return "<td>" + html + "</td>"; }

std::string row_head(const std::string& text) {
  return "<th scope=\"row\">" + escape_html(text) + "</th>";
}

std::string or_dash(const std::string& text) {
  return text.empty() ? kNoFigure : escape_html(text);
}

Rounding rounding_of(Quantity quantity) {
  if (quantity == Quantity::kCount) return Rounding::kCount;
  return quantity == Quantity::kFraction ? Rounding::kPercent : Rounding::kThreeDigits;
}

// `place` is below /comparison.
std::string shown(Quantity quantity, const std::optional<double>& value, const std::string& place,
                  const std::string& unit = "") {
  if (!value) return kNoFigure;
  if (quantity == Quantity::kTruth) return *value != 0.0 ? "yes" : "no";
  return shown_number(json_of(quantity, value), "/comparison" + place, rounding_of(quantity), unit);
}

std::string shown(double value, const std::string& place, const std::string& unit = "") {
  return shown(Quantity::kNumber, value, place, unit);
}

std::string with_sign(const std::optional<double>& value, const std::string& html) {
  return (value && *value > 0.0 ? "+" : "") + html;
}

std::string table(const char* label, const std::vector<std::string>& heads,
                  const std::string& rows) {
  std::string html = "<table class=\"compared\"><thead><tr>";
  for (const std::string& head : heads) html += "<th>" + escape_html(head) + "</th>";
  return scrolling_region(label, html + "</tr></thead><tbody>\n" + rows + "</tbody></table>");
}

// Summary

std::string frame_in_words(const RunComparison& comparison) {
  const FrameMotion& frame = comparison.frame;
  if (frame.views > 0)
    return fmt::format(
        "<p>B was brought into the frame of A by the poses of {} views that both runs placed: "
        "turned by {}°, its middle moved by {}.</p>\n",
        frame.views, shown(frame.rotation_deg, "/frame/rotation_deg"),
        shown(frame.shift, "/frame/shift", comparison.unit));
  return comparison.poses || comparison.models ? "<p>The frames of A and B were taken as one.</p>\n"
                                               : "";
}

std::string tile(const std::string& figure, const std::string& what) {
  return fmt::format("<li><b>{}</b><span>{}</span></li>\n", figure, what);
}

// Nothing where one run did not record its inputs.
std::optional<double> views_with_other_inputs(const RunComparison& comparison) {
  double count = 0.0;
  for (const ComparedView& view : comparison.views) {
    if (view.input == InputState::kNotRecorded) return std::nullopt;
    count += view.input != InputState::kSame;
  }
  return count;
}

std::string summary_tiles(const RunComparison& comparison) {
  const auto matter = std::count_if(comparison.options.begin(), comparison.options.end(),
                                    [](const auto& option) { return option.changes_result; });
  const auto inputs = views_with_other_inputs(comparison);
  std::string html =
      tile(std::to_string(matter), "options that differ") +
      tile(inputs ? fmt::format("{:.0f}", *inputs) : kNoFigure, "views with other inputs");
  const std::string& unit = comparison.unit;
  if (comparison.poses)
    html += tile(shown(comparison.poses->mean_displacement, "/poses/mean_displacement", unit),
                 "mean displacement of the poses");
  if (comparison.models) {
    const auto& distances = comparison.models->distances;
    html += tile(shown(distances.a_to_b.all.distance.rms, "/models/a_to_b/rms", unit),
                 "from A to B, RMS") +
            tile(shown(distances.b_to_a.all.distance.rms, "/models/b_to_a/rms", unit),
                 "from B to A, RMS");
  }
  return "<ul class=\"tiles\">\n" + html + "</ul>\n";
}

std::string comparison_summary(const RunComparison& comparison) {
  std::string html = "<section id=\"summary\"><h2>Summary</h2>\n";
  for (const auto& [name, side] : {std::pair("A", &comparison.a), std::pair("B", &comparison.b)})
    html += fmt::format("<p><b>{}</b> is <code>{}</code>{}.</p>\n", name, escape_html(side->folder),
                        side->finished ? "" : ", a run that did not finish");
  html += summary_tiles(comparison) + frame_in_words(comparison);
  if (!comparison.notes.empty()) {
    html += "<h3>To know before reading</h3>\n<ul>";
    for (const std::string& note : comparison.notes) html += "<li>" + escape_html(note) + "</li>\n";
    html += "</ul>\n";
  }
  return html + "</section>\n";
}

// Models

std::string distance_row(const std::string& name, const evaluation::DirectedDistance& way,
                         const std::string& place) {
  const evaluation::ErrorStatistics& distance = way.distance;
  if (distance.count == 0) return "";
  std::string html = "<tr>" + row_head(name);
  for (const auto& [key, value] :
       {std::pair("/mean", distance.mean), std::pair("/median", distance.median),
        std::pair("/rms", distance.rms), std::pair("/p95", distance.p95),
        std::pair("/max", distance.max), std::pair("/normals_deg/mean", way.normals_deg.mean)})
    html += cell(shown(value, place + key));
  return html + "</tr>\n";
}

std::string distance_rows(const std::string& name, const evaluation::DistanceReport& way,
                          const std::string& place) {
  std::string html = distance_row(name, way.all, place);
  if (way.measured)
    html += distance_row(name + ", measured part", *way.measured, place + "/measured");
  if (way.filled) html += distance_row(name + ", filled part", *way.filled, place + "/filled");
  return html;
}

std::string within_rows(const evaluation::MutualDistances& distances) {
  std::string html;
  for (std::size_t i = 0; i < distances.thresholds.size(); ++i) {
    const std::string number = "/" + std::to_string(i);
    html += "<tr><th scope=\"row\">" +
            shown(distances.thresholds[i], "/models/thresholds" + number) + "</th>";
    for (const auto& [key, way] :
         {std::pair("a_to_b", &distances.a_to_b), std::pair("b_to_a", &distances.b_to_a)})
      html += cell(shown(Quantity::kFraction, way->all.within[i],
                         fmt::format("/models/{}/within{}", key, number)));
    html += "</tr>\n";
  }
  return html;
}

std::string picture_rows(const std::vector<ReportPicture>& pictures) {
  std::string html;
  for (const ReportPicture& picture : pictures) html += picture_figure(picture);
  return html.empty() ? "" : "<div class=\"pictures pairs\">\n" + html + "</div>\n";
}

std::string models_section(const RunComparison& comparison,
                           const std::vector<ReportPicture>& pictures) {
  if (!comparison.models) return "";
  const ComparedModels& models = *comparison.models;
  const std::string unit = " [" + comparison.unit + "]";
  return fmt::format(
             "<section id=\"models\"><h2>Models</h2>\n{}<p>Red is outside of the other model, blue "
             "inside, grey on it. Full colour is {} and more.</p>\n<h3>Distances</h3>\n",
             picture_rows(pictures),
             shown(models.colour_scale, "/models/colour_scale", comparison.unit)) +
         table("Distances between the models",
               {"Surface", "Mean" + unit, "Median" + unit, "RMS" + unit, "95 %" + unit,
                "Max" + unit, "Normals, mean [°]"},
               distance_rows("A to B", models.distances.a_to_b, "/models/a_to_b") +
                   distance_rows("B to A", models.distances.b_to_a, "/models/b_to_a")) +
         table("Share of the surfaces within a distance",
               {"Within" + unit, "of A's surface", "of B's surface"},
               within_rows(models.distances)) +
         "</section>\n";
}

// Figures, views, provenance

std::string group_title(const std::string& group) {
  if (group == "cost") return "Time and memory";
  std::string title = group;
  title[0] = static_cast<char>(title[0] - 'a' + 'A');
  return title;
}

std::string figure_row(const ComparedFigure& figure, const std::string& length) {
  const std::string place = "/figures/" + figure.group + "/" + figure.key;
  const std::string unit = unit_of(figure.quantity, length);
  const auto difference = figure.difference(), ratio = figure.ratio();
  return "<tr>" + row_head(unit.empty() ? figure.title : figure.title + " [" + unit + "]") +
         cell(shown(figure.quantity, figure.a, place + "/a")) +
         cell(shown(figure.quantity, figure.b, place + "/b")) +
         cell(with_sign(difference, shown(figure.quantity, difference, place + "/difference"))) +
         cell(shown(Quantity::kNumber, ratio, place + "/ratio")) + "</tr>\n";
}

std::string figures_section(const RunComparison& comparison) {
  std::string html = "<section id=\"figures\"><h2>Figures</h2>\n", rows, group;
  const auto end_group = [&] {
    if (!rows.empty())
      html += "<h3>" + group_title(group) + "</h3>\n" +
              table("Figures of both runs", {"", "A", "B", "B - A", "B / A"}, rows);
    rows.clear();
  };
  for (const ComparedFigure& figure : comparison.figures) {
    if (!figure.a && !figure.b) continue;
    if (figure.group != group) end_group();
    group = figure.group;
    rows += figure_row(figure, comparison.unit);
  }
  end_group();
  return html + "</section>\n";
}

std::string view_row(const ComparedView& view, const std::string& place) {
  std::string html = "<tr>" + row_head(view.name);
  for (const std::string& text : {to_string(view.input), view.a.alignment, view.b.alignment,
                                  view.a.refinement, view.b.refinement})
    html += cell(or_dash(text));
  if (view.pose)
    html += cell(shown(view.pose->rotation_deg, place + "/pose/rotation_deg")) +
            cell(shown(view.pose->mean_displacement, place + "/pose/mean_displacement"));
  else
    html += cell(kNoFigure) + cell(kNoFigure);
  const auto pair = [&](const char* key, const auto& a, const auto& b) {
    html += cell(shown(Quantity::kLength, a, place + key + "/a")) +
            cell(shown(Quantity::kLength, b, place + key + "/b"));
  };
  pair("/rms_change", view.a.rms_change, view.b.rms_change);
  pair("/median_deviation", view.a.median_deviation, view.b.median_deviation);
  return html + "</tr>\n";
}

std::string compared_views_section(const RunComparison& comparison) {
  if (comparison.views.empty()) return "";
  const std::string unit = " [" + comparison.unit + "]";
  std::string rows;
  for (std::size_t i = 0; i < comparison.views.size(); ++i)
    rows += view_row(comparison.views[i], "/views/" + std::to_string(i));
  return "<section id=\"views\"><h2>Views</h2>\n<p>How far the poses of B are from those of A, "
         "after the frames were brought together: the angle, and how far the view's samples "
         "move in the mean.</p>\n" +
         table("Views of both runs",
               {"View", "Input", "Status in A", "in B", "Refinement in A", "in B", "Turned [°]",
                "Moved" + unit, "Moved by refining in A" + unit, "in B" + unit,
                "Expected error in A" + unit, "in B" + unit},
               rows) +
         "</section>\n";
}

std::string side_rows(const RunComparison& comparison) {
  const auto row = [](const char* what, const std::string& a, const std::string& b) {
    return "<tr>" + row_head(what) + cell(or_dash(a)) + cell(or_dash(b)) + "</tr>\n";
  };
  const RunSide &a = comparison.a, &b = comparison.b;
  return row("Version of relief", a.version, b.version) +
         row("Build", a.program.substr(0, 12), b.program.substr(0, 12)) +
         row("Input", a.input, b.input);
}

std::string option_rows(const RunComparison& comparison) {
  std::string html;
  for (const ComparedOption& option : comparison.options)
    html += "<tr>" + row_head(option.name) + cell(escape_html(option.a.value_or("default"))) +
            cell(escape_html(option.b.value_or("default"))) +
            cell(option.changes_result ? "" : "changes no result") + "</tr>\n";
  return html;
}

std::string origin_section(const RunComparison& comparison) {
  const std::string options = option_rows(comparison);
  return "<section id=\"provenance\"><h2>Provenance</h2>\n" +
         table("Where the runs come from", {"", "A", "B"}, side_rows(comparison)) +
         "<h3>Options that differ</h3>\n" +
         (options.empty() ? "<p>None.</p>\n"
                          : table("Options that differ", {"Option", "A", "B", ""}, options)) +
         "</section>\n";
}

}  // namespace

std::string comparison_page(const RunComparison& comparison,
                            const std::vector<ReportPicture>& pictures) {
  return fill_page({.title = comparison.a.folder + " and " + comparison.b.folder,
                    .kind = "comparison",
                    .sections = {comparison_summary(comparison),
                                 models_section(comparison, pictures), figures_section(comparison),
                                 compared_views_section(comparison), origin_section(comparison)},
                    .figures = {{"relief", kVersion}, {"comparison", to_json(comparison)}},
                    .exact = "part of this page",
                    .credit = "",
                    .scripts = ""});
}

}  // namespace relief
