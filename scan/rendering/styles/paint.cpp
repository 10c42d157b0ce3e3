#include "scan/rendering/styles/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "scan/base/srgb.h"

namespace relief::rendering {

namespace {

// For every byte.
std::array<double, 256> light_of_bytes() {
  std::array<double, 256> lights{};
  for (std::size_t byte = 0; byte < lights.size(); ++byte) {
    lights[byte] = linear_from_srgb(static_cast<double>(byte) / 255.0);
  }
  return lights;
}

std::uint8_t byte_of(double light) {
  return static_cast<std::uint8_t>(
      std::lround(255.0 * std::clamp(srgb_from_linear(light), 0.0, 1.0)));
}

// Azimuth and elevation [deg].
constexpr LightDirection kFrontLight{-25.0, 30.0}, kGrazingLight{-65.0, 30.0};
// Fraction of the light, from the viewer: more shows shadowed form, less leaves more contrast to
// the light from the side. A free choice of pictures.
constexpr double kFrontFill = 0.25, kGrazingFill = 0.02;

// What a style needs, as an error says it.
struct Need {
  std::size_t entries;
  const char* what;
  const char* remedy;
};

Result<void> check(RenderStyle style, const PaintContext& context, const Need& need) {
  if (need.entries == context.mesh.vertices.size()) return {};
  return Error{ErrorKind::kBadInput, "the style " + std::string(to_string(style)) +
                                         " needs for each vertex " + need.what + ": " +
                                         need.remedy};
}

constexpr const char* kModels =
    "models that 'relief merge' wrote as .ply or .vtp have it; choose another style here";
constexpr const char* kModelsAndViews =
    "models that 'relief merge' wrote as .ply or .vtp and refined views have it; choose another "
    "style here";

}  // namespace

LinearColour linear_of(const Colour& colour) {
  static const std::array<double, 256> kLights = light_of_bytes();
  return {kLights[colour[0]], kLights[colour[1]], kLights[colour[2]]};
}

Colour srgb_of(const LinearColour& colour) {
  return {byte_of(colour[0]), byte_of(colour[1]), byte_of(colour[2])};
}

std::string_view to_string(RenderStyle style) {
  switch (style) {
    case RenderStyle::kShaded:
      return "shaded";
    case RenderStyle::kGrazing:
      return "grazing";
    case RenderStyle::kAccessibility:
      return "accessibility";
    case RenderStyle::kDepth:
      return "depth";
    case RenderStyle::kNormals:
      return "normals";
    case RenderStyle::kExpectedError:
      return "expected_error";
    case RenderStyle::kFilled:
      return "filled";
    case RenderStyle::kViews:
      return "views";
    case RenderStyle::kDistance:
      return "distance";
    case RenderStyle::kColours:
      return "colours";
  }
  return "unknown";
}

Result<StylePaint> paint_of(RenderStyle style, const PaintContext& context) {
  const TriangleMesh& mesh = context.mesh;
  const RenderOptions& options = context.options;
  const auto with = [&](const Need& need, StylePaint (*make)(const PaintContext&)) {
    const auto checked = check(style, context, need);
    return checked ? Result<StylePaint>(make(context)) : Result<StylePaint>(checked.error());
  };
  switch (style) {
    case RenderStyle::kShaded:
      return lit_paint(context, options.light.value_or(kFrontLight), kFrontFill);
    case RenderStyle::kGrazing:
      return lit_paint(context, options.light.value_or(kGrazingLight), kGrazingFill);
    case RenderStyle::kAccessibility:
      return accessibility_paint(context);
    case RenderStyle::kDepth:
      return depth_paint(context);
    case RenderStyle::kNormals:
      return normal_paint(context);
    case RenderStyle::kExpectedError:
      return with({mesh.quality.size(), "its expected error (quality)", kModelsAndViews},
                  expected_error_paint);
    case RenderStyle::kFilled:
      return with({mesh.filled.size(), "whether it was filled (filled)", kModels}, filled_paint);
    case RenderStyle::kViews:
      return with({mesh.views.size(), "how many views measured it (views)", kModels}, views_paint);
    case RenderStyle::kDistance:
      return with({options.distances.size(), "its distance to another surface",
                   "measure it against a reference (--truth)"},
                  distance_paint);
    case RenderStyle::kColours:
      return with({mesh.colours.size(), "a colour (red green blue)", "choose another style here"},
                  colour_paint);
  }
  return Error{ErrorKind::kBadInput, "unknown style"};
}

}  // namespace relief::rendering
