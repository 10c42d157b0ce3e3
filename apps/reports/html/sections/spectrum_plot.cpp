#include "apps/reports/html/sections/spectrum_plot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "apps/reports/html/html_text.h"

namespace relief {

namespace {

constexpr double kFieldWidth = 400.0, kFieldHeight = 150.0;  // Of the field of the plot.

struct SpectrumPoint {
  double wavelength, measured, refined;
};

std::vector<SpectrumPoint> bands_of(const ReportFigures& report, const std::string& entry) {
  std::vector<SpectrumPoint> points;
  for (const std::string& band : report.entries(entry + "/spectrum")) {
    const SpectrumPoint point{report.number(band + "/wavelength").value_or(0.0),
                              report.number(band + "/measured").value_or(0.0),
                              report.number(band + "/refined").value_or(0.0)};
    if (point.wavelength > 0.0 && point.measured > 0.0 && point.refined > 0.0)
      points.push_back(point);
  }
  return points;
}

// Both axes are logarithmic; the vertical one has whole powers of ten at its ends.
class SpectrumPlot {
 public:
  SpectrumPlot(const std::vector<SpectrumPoint>& points, std::string unit)
      : points_(points), unit_(std::move(unit)) {
    for (const SpectrumPoint& point : points) {
      for (const double value : {point.measured, point.refined}) {
        low_ = std::min(low_, std::floor(std::log10(value)));
        high_ = std::max(high_, std::ceil(std::log10(value)));
      }
    }
    high_ = std::max(high_, low_ + 1.0);
  }

  std::string svg() const {
    return "<svg viewBox=\"-72 -12 490 214\" role=\"img\" aria-label=\"Deviation by wavelength, "
           "measured and refined\">\n" +
           grid() + line("measured", &SpectrumPoint::measured) +
           line("refined", &SpectrumPoint::refined) + "</svg>";
  }

 private:
  double x(double wavelength) const {
    const double first = std::log2(points_.front().wavelength);
    const double last = std::log2(points_.back().wavelength);
    return last > first ? kFieldWidth * (std::log2(wavelength) - first) / (last - first) : 0.0;
  }
  double y(double value) const {
    return kFieldHeight * (high_ - std::log10(value)) / (high_ - low_);
  }

  std::string grid() const {
    std::string svg;
    for (double power = low_; power <= high_; ++power) {
      const double place = y(std::pow(10.0, power));
      svg += fmt::format(
          R"(<line class="grid" x1="0" y1="{0:.1f}" x2="{1}" y2="{0:.1f}"/><text x="-6" y="{2:.1f}" text-anchor="end">{3:g}</text>)"
          "\n",
          place, kFieldWidth, place + 4.0, std::pow(10.0, power));
    }
    for (const SpectrumPoint& point : points_)
      svg += fmt::format(R"(<text x="{:.1f}" y="168" text-anchor="middle">{:g}</text>)"
                         "\n",
                         x(point.wavelength), point.wavelength);
    return svg + fmt::format(
                     "<text x=\"{}\" y=\"190\" text-anchor=\"middle\">wavelength [samples]"
                     "</text>\n",
                     0.5 * kFieldWidth);
  }

  std::string line(const char* name, double SpectrumPoint::*value) const {
    std::string path, dots;
    for (const SpectrumPoint& point : points_) {
      const double px = x(point.wavelength), py = y(point.*value);
      path += fmt::format("{:.1f},{:.1f} ", px, py);
      dots += fmt::format(
          R"(<circle class="{}" cx="{:.1f}" cy="{:.1f}" r="3.5"><title>{}, {:g} samples: {} {}</title></circle>)"
          "\n",
          name, px, py, name, point.wavelength, three_digits(point.*value), escape_html(unit_));
    }
    return fmt::format("<polyline class=\"{}\" points=\"{}\"/>\n", name, path) + dots;
  }

  const std::vector<SpectrumPoint>& points_;
  std::string unit_;
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();  // Powers of ten.
};

}  // namespace

std::string spectrum_of_view(const ReportContent& content, const std::string& entry) {
  const ReportFigures& report = content.report;
  const std::vector<SpectrumPoint> points = bands_of(report, entry);
  if (points.size() < 2) return "";
  const std::string first = entry + "/spectrum/0";
  return fmt::format(
             "<p>From sample to sample its ranges deviated by {} from what its normals say; "
             "refined "
             "they do by {}.</p>\n",
             report.shown(first + "/measured", Rounding::kThreeDigits, content.unit),
             report.shown(first + "/refined", Rounding::kThreeDigits, content.unit)) +
         "<figure class=\"spectrum\">" + SpectrumPlot(points, content.unit).svg() +
         fmt::format(
             "<figcaption>How far ranges deviate from the surface that the measured normals of the "
             "same view imply, for one sample [{}], by wavelength: <span "
             "class=\"key measured\">measured</span> and <span class=\"key "
             "refined\">refined</span>. Short waves are noise of the ranges, which refining takes "
             "away. Long waves are slow errors of the normals: there refined ranges stay with the "
             "measured ones. This is no error against the truth, which a scan does not know."
             "</figcaption></figure>\n",
             escape_html(content.unit));
}

}  // namespace relief
