#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "scan/rendering/pictures/colour_maps.h"
#include "scan/rendering/styles/paint.h"

namespace relief::rendering {

namespace {

constexpr Colour kMeasured{205, 205, 200}, kFilled{235, 130, 30}, kUnknown{150, 150, 150};
// Fraction of the values below the end of the bar: few large errors would make all others look
// alike.
constexpr double kShown = 0.95;

std::string with_unit(const std::string& title, const std::string& unit) {
  return unit.empty() ? title : title + " [" + unit + "]";
}

// The value below which kShown of them are; 1 where that is 0, for a bar with two ends.
double most_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return 1.0;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(kShown * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place > 0.0 ? *place : 1.0;
}

// `values` blended over each face; not finite is grey.
StylePaint value_paint(const PaintContext& context, std::vector<double> values, Legend legend) {
  if (context.options.range) {
    legend.low = (*context.options.range)[0];
    legend.high = (*context.options.range)[1];
  }
  Paint paint = [context, values = std::move(values), map = legend.bar, low = legend.low,
                 high = legend.high](const VisiblePoint& point) -> LinearColour {
    double value = 0.0;
    for (int k = 0; k < 3; ++k)
      value += point.weights[k] * values[context.mesh.faces[point.face][k]];
    const Colour colour = std::isfinite(value) ? colour_at(map, value, low, high) : kUnknown;
    return soft_light(context, point) * linear_of(colour);
  };
  return {std::move(paint), std::move(legend)};
}

double filled_share(const TriangleMesh& mesh, const VisiblePoint& point) {
  double share = 0.0;
  for (int k = 0; k < 3; ++k) share += point.weights[k] * mesh.filled[mesh.faces[point.face][k]];
  return share;
}

}  // namespace

StylePaint depth_paint(const PaintContext& context) {
  const auto [low, high] = context.options.range.value_or(context.ranges);
  Legend legend{with_unit("range", context.options.unit), low, high, sequential_map(), {}};
  // Near is bright.
  std::reverse(legend.bar.begin(), legend.bar.end());
  return {[map = legend.bar, low = low, high = high](const VisiblePoint& point) {
            return linear_of(colour_at(map, point.range, low, high));
          },
          legend};
}

StylePaint filled_paint(const PaintContext& context) {
  Legend legend;
  legend.entries = {{kMeasured, "measured"}, {kFilled, "filled"}};
  return {[context](const VisiblePoint& point) -> LinearColour {
            const Colour colour = filled_share(context.mesh, point) >= 0.5 ? kFilled : kMeasured;
            return soft_light(context, point) * linear_of(colour);
          },
          legend};
}

StylePaint expected_error_paint(const PaintContext& context) {
  const TriangleMesh& mesh = context.mesh;
  std::vector<double> errors(mesh.quality.begin(), mesh.quality.end());
  const bool any_filled = std::any_of(mesh.filled.begin(), mesh.filled.end(),
                                      [](std::uint8_t filled) { return filled != 0; });
  if (any_filled && mesh.filled.size() == errors.size())
    for (std::size_t i = 0; i < errors.size(); ++i)
      if (mesh.filled[i]) errors[i] = std::nan("");
  Legend legend{with_unit("expected error", context.options.unit),
                0.0,
                most_of(errors),
                sequential_map(),
                {}};
  if (any_filled) legend.entries = {{kUnknown, "filled"}};
  return value_paint(context, std::move(errors), std::move(legend));
}

StylePaint views_paint(const PaintContext& context) {
  const auto& views = context.mesh.views;
  const double most = *std::max_element(views.begin(), views.end());
  return value_paint(context, {views.begin(), views.end()},
                     {"views", 0.0, std::max(most, 1.0), sequential_map(), {}});
}

StylePaint distance_paint(const PaintContext& context) {
  std::vector<double> magnitudes;
  for (const double distance : context.options.distances) magnitudes.push_back(std::abs(distance));
  const double scale = most_of(std::move(magnitudes));
  return value_paint(
      context, context.options.distances,
      {with_unit("distance", context.options.unit), -scale, scale, diverging_map(), {}});
}

}  // namespace relief::rendering
