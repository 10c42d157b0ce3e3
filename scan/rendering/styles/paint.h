#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "relief/rendering/picture.h"
#include "relief/rendering/render_mesh.h"
#include "relief/scan/grid.h"
#include "scan/rendering/rays/ray_caster.h"

namespace relief::rendering {

/// Red, green and blue in proportion to light, 1 is white.
using LinearColour = Eigen::Array3d;

LinearColour linear_of(const Colour& colour);
/// Clamped to 0..255.
Colour srgb_of(const LinearColour& colour);

/// What a ray of a picture meets.
struct VisiblePoint {
  std::uint32_t face = 0;
  Eigen::Vector3d weights, place;  ///< Barycentric weights; in the world.
  Eigen::Vector3d normal;          ///< For shading: unit, on the viewer's side of the face.
  Eigen::Vector3d face_normal;     ///< Unit, towards the viewer.
  double range = 0.0;              ///< t of the ray.
  bool back = false;               ///< The viewer sees the inside of the face.
  std::uint64_t stream = 0;        ///< Of random numbers: differs from ray to ray.
};

using Paint = std::function<LinearColour(const VisiblePoint&)>;

/// How a style colours a surface.
struct StylePaint {
  Paint paint;
  std::optional<Legend> legend;
};

/// What paints may know of the picture.
struct PaintContext {
  const TriangleMesh& mesh;
  const RayCaster& caster;
  double diagonal = 0.0;  ///< Of the mesh's bounding box [unit].
  Eigen::Matrix3d picture_axes;
  std::array<double, 2> ranges{};  ///< Least and largest range in the picture; of kDepth only.
  const RenderOptions& options;
};

/// kBadInput: the mesh or the options lack what the style shows.
Result<StylePaint> paint_of(RenderStyle style, const PaintContext& context);

/// The single paints.
StylePaint lit_paint(const PaintContext& context, const LightDirection& light, double fill);
StylePaint accessibility_paint(const PaintContext& context);
StylePaint normal_paint(const PaintContext& context);
StylePaint colour_paint(const PaintContext& context);
StylePaint depth_paint(const PaintContext& context);
StylePaint filled_paint(const PaintContext& context);
StylePaint expected_error_paint(const PaintContext& context);
StylePaint views_paint(const PaintContext& context);
StylePaint distance_paint(const PaintContext& context);

/// A light that follows the viewer, for colours that are values: between 0.45 and 1, so that shapes
/// show and colours stay readable.
double soft_light(const PaintContext& context, const VisiblePoint& point);

}  // namespace relief::rendering
