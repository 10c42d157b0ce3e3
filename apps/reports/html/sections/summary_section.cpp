#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "apps/reports/html/html_text.h"
#include "apps/reports/html/report_content.h"

namespace relief {

namespace {

std::string item(const std::string& html) { return "<li>" + html + "</li>\n"; }

std::vector<std::string> names_of(const ReportContent& content, ViewGrade grade) {
  std::vector<std::string> names;
  for (const GradedView& view : content.views)
    if (view.grade == grade) names.push_back(view.name);
  return names;
}

std::string size_in_words(const ReportContent& content) {
  if (!content.model) return "";
  const Eigen::Vector3d size = content.model->high - content.model->low;
  return fmt::format(", {} × {} × {} {} in size", three_digits(size.x()), three_digits(size.y()),
                     three_digits(size.z()), escape_html(content.unit));
}

std::string lead(const ReportContent& content) {
  const ReportFigures& report = content.report;
  const std::string views =
      fmt::format("{} {}", content.views.size(), content.views.size() == 1 ? "view" : "views");
  if (!report.find("/merge")) return "The folder has the report of " + views + ", but no model.";
  return fmt::format("{} became one {} model of {} vertices and {} faces{}.",
                     content.views.empty() ? "The views" : views,
                     report.truth("/merge/watertight").value_or(false) ? "watertight" : "open",
                     report.shown("/merge/vertices", Rounding::kCount),
                     report.shown("/merge/faces", Rounding::kCount), size_in_words(content));
}

std::string tile(const std::string& value, const std::string& label) {
  return fmt::format("<li><b>{}</b><span>{}</span></li>\n", value, label);
}

std::string tiles(const ReportContent& content) {
  const ReportFigures& report = content.report;
  const std::size_t good = names_of(content, ViewGrade::kGood).size();
  std::string html;
  if (!content.views.empty())
    html += tile(fmt::format("{} of {}", good, content.views.size()), "views without objection");
  if (report.number(report.alignment() + "/rms"))
    html += tile(report.shown(report.alignment() + "/rms", Rounding::kThreeDigits, content.unit),
                 "residual between aligned views");
  if (content.model && content.model->expected_error)
    html += tile(three_digits(content.model->median_error) + "&nbsp;" + escape_html(content.unit),
                 "expected error of a typical vertex");
  if (report.number("/merge/filled_area_fraction"))
    html += tile(report.shown("/merge/filled_area_fraction", Rounding::kPercent),
                 "of the surface measured by no view");
  return html.empty() ? "" : "<ul class=\"tiles\">" + html + "</ul>\n";
}

double fraction_seen_twice(const ModelStatistics& model) {
  const auto& counts = model.vertices_by_views;
  const double all = std::accumulate(counts.begin(), counts.end(), 0.0);
  const double once = (counts.size() > 0 ? counts[0] : 0.0) + (counts.size() > 1 ? counts[1] : 0.0);
  return all > 0.0 ? 1.0 - once / all : 0.0;
}

std::string good_poses(const ReportContent& content) {
  const ReportFigures& report = content.report;
  const std::vector<std::string> views = report.entries(report.alignment() + "/views");
  const auto verified = std::count_if(views.begin(), views.end(), [&](const std::string& view) {
    return report.text(view + "/status") == "verified";
  });
  if (verified == 0) return "";
  return item(
      fmt::format("{} {} at poses that other views confirm.",
                  verified == std::ssize(views) ? "All views" : fmt::format("{} views", verified),
                  verified == 1 ? "stands" : "stand"));
}

// What calibration corrected, in its own words.
std::string good_calibration(const ReportContent& content) {
  std::string html;
  for (const std::string& note : content.report.entries("/calibrate/notes"))
    html += item("Sensors: " + escape_html(content.report.text(note)) + ".");
  return html;
}

std::string good_refinement(const ReportContent& content) {
  const ReportFigures& report = content.report;
  std::string html;
  if (report.truth("/align_again/gain/kept").value_or(false))
    html += item(fmt::format(
        "Refining the views lowered the residual between them from {} to {}.",
        report.shown("/align_again/gain/rms/first", Rounding::kThreeDigits, content.unit),
        report.shown("/align_again/gain/rms/again", Rounding::kThreeDigits, content.unit)));
  return html;
}

std::string good_model(const ReportContent& content) {
  std::string html;
  if (content.report.truth("/merge/watertight").value_or(false))
    html += item("The model is closed, has a consistent orientation and an inside.");
  if (!content.model) return html;
  if (!content.model->vertices_by_views.empty())
    html += item(fmt::format("Two or more views measured {:.1f}&nbsp;% of the vertices.",
                             100.0 * fraction_seen_twice(*content.model)));
  if (content.model->expected_error)
    html += item(
        fmt::format("95&nbsp;% of the measured vertices have an expected error below {}&nbsp;{}.",
                    three_digits(content.model->error_p95), escape_html(content.unit)));
  return html;
}

std::string to_rescan(const ReportContent& content, ViewGrade grade) {
  std::string html;
  for (const GradedView& view : content.views) {
    if (view.grade != grade) continue;
    std::string reasons;
    for (const std::string& reason : view.reasons) reasons += " " + escape_html(reason);
    html += item(fmt::format("View <strong>{}</strong>.{}", escape_html(view.name), reasons));
  }
  return html;
}

Eigen::Vector3d place_of(const ViewCamera& camera) {
  Eigen::Vector3d place;
  for (int axis = 0; axis < 3; ++axis) place[axis] = camera.world_from_view[axis][3];
  return place;
}

// The view that stood nearest to a line from the region outwards.
std::string nearest_view(const FilledRegion& region, const std::vector<ViewCamera>& cameras) {
  double best = -2.0;
  std::string name;
  for (const ViewCamera& camera : cameras) {
    const double cosine =
        (place_of(camera) - region.centre).normalized().dot(region.outward.normalized());
    if (!(cosine > best)) continue;
    best = cosine;
    name = camera.name;
  }
  return name;
}

std::string place_text(const Eigen::Vector3d& v) {
  return fmt::format("{:.3g}, {:.3g}, {:.3g}", v.x(), v.y(), v.z());
}

// Two decimals of a unit vector are half a degree.
std::string direction_text(const Eigen::Vector3d& v) {
  const Eigen::Vector3d whole = (100.0 * v).array().round() + 0.0;  // No negative zeros.
  return fmt::format("{:.2f}, {:.2f}, {:.2f}", whole.x() / 100.0, whole.y() / 100.0,
                     whole.z() / 100.0);
}

std::string vector_attribute(const Eigen::Vector3d& v) {
  return fmt::format("{} {} {}", v.x(), v.y(), v.z());
}

std::string region_item(const FilledRegion& region, const ReportContent& content) {
  constexpr double kOneSided = 0.3;  // Below, the surface faces all round.
  std::string html = fmt::format(
      "No view measured a region of {} {}² ({} % of the surface) around ({}).",
      three_digits(region.area), escape_html(content.unit),
      three_digits(100.0 * region.area / content.model->area), place_text(region.centre));
  if (region.outward.norm() > kOneSided) {
    html += fmt::format(" Scan it from the direction ({})",
                        direction_text(region.outward.normalized()));
    const std::string nearest = nearest_view(region, content.cameras);
    html += nearest.empty() ? "." : "; the nearest view is " + escape_html(nearest) + ".";
  } else {
    html += " It faces all round: more than one view is needed.";
  }
  if (content.viewer)
    html += fmt::format(
        R"( <button type="button" class="show" data-centre="{}" data-outward="{}">Show</button>)",
        vector_attribute(region.centre), vector_attribute(region.outward));
  return item(html);
}

std::string unmeasured_regions(const ReportContent& content) {
  constexpr double kWorthAScan = 0.005;  // Of the area.
  constexpr std::size_t kMost = 5;
  if (!content.model) return "";
  std::string html;
  std::size_t shown = 0, left = 0;
  for (const FilledRegion& region : content.model->regions) {
    if (region.area < kWorthAScan * content.model->area) continue;
    if (shown < kMost)
      html += region_item(region, content);
    else
      ++left;
    shown += shown < kMost ? 1 : 0;
  }
  if (left > 0) html += item(fmt::format("{} smaller regions were not measured either.", left));
  return html;
}

// What the steps told beside their figures. Calibration's are among what is good.
std::string notes(const ReportContent& content) {
  const ReportFigures& report = content.report;
  std::string html;
  for (const auto& [step, place] : {std::pair<std::string, std::string>{"Reading", "/run/notes"},
                                    {"Alignment", report.alignment() + "/notes"},
                                    {"Merging", "/merge/notes"}})
    for (const std::string& note : report.entries(place))
      html += item(step + ": " + escape_html(report.text(note)) + ".");
  return html.empty() ? "" : "<h3>Notes</h3>\n<ul>" + html + "</ul>\n";
}

std::string list(const char* title, const std::string& items, const char* none) {
  return fmt::format("<div><h3>{}</h3>\n<ul>{}</ul></div>\n", title,
                     items.empty() ? item(none) : items);
}

}  // namespace

std::string summary_section(const ReportContent& content) {
  const std::string good = good_poses(content) + good_calibration(content) +
                           good_refinement(content) + good_model(content);
  const std::string rescan = to_rescan(content, ViewGrade::kRescan) + unmeasured_regions(content);
  const std::string check = to_rescan(content, ViewGrade::kCheck);
  return fmt::format(
      "<section id=\"summary\"><h2>Summary</h2>\n<p class=\"lead\">{}</p>\n{}<div "
      "class=\"columns\">\n{}{}{}</div>\n{}</section>\n",
      lead(content), tiles(content), list("What is good", good, "Nothing could be confirmed."),
      list("What to scan again", rescan, "Nothing."), list("What to check", check, "Nothing."),
      notes(content));
}

}  // namespace relief
