#include "hybrid/model/view_part.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "relief/scan/camera.h"
#include "relief/scan/grid.h"

namespace relief::hybrid {

namespace {

// Parts begin where blocks of pixels do over which noise and smooth change are averaged: else these
// would be other blocks than in the whole view.
constexpr int kBlock = 8;

// Pixels kept around the samples of a masked view: beyond them no step looks for what is there.
constexpr int kMargin = 16;

// Views whose samples take a smaller part of the grid than that are refined without the rest: many
// steps go through all pixels. Above, what is saved is no more than copying costs.
constexpr double kMasked = 0.9;

template <typename T>
Grid<T> crop(const Grid<T>& grid, const ViewPart& part) {
  if (grid.empty()) return {};
  Grid<T> cropped(part.width, part.height, grid[0]);
  for (int v = 0; v < part.height; ++v)
    for (int u = 0; u < part.width; ++u) cropped(u, v) = grid(part.u + u, part.v + v);
  return cropped;
}

// The grid of the part within one of the size of the whole, which is `around` it, or `value` where
// there is none.
template <typename T>
Grid<T> within(const RangeView& whole, const Grid<T>& around, const T& value, const ViewPart& part,
               const Grid<T>& from) {
  if (from.empty()) return {};
  Grid<T> all = around.empty() ? Grid<T>(whole.width(), whole.height(), value) : around;
  for (int v = 0; v < part.height; ++v)
    for (int u = 0; u < part.width; ++u) all(part.u + u, part.v + v) = from(u, v);
  return all;
}

Camera crop(const Camera& camera, const ViewPart& part) {
  PinholeIntrinsics k = camera.intrinsics();
  k.cx -= part.u;
  k.cy -= part.v;
  if (camera.model() == Camera::Model::kPinhole) return Camera::pinhole(part.width, part.height, k);
  if (camera.model() == Camera::Model::kPinholeGl)
    return Camera::pinhole_gl(part.width, part.height, k);
  Grid<Ray> rays(part.width, part.height);
  for (int v = 0; v < part.height; ++v)
    for (int u = 0; u < part.width; ++u) rays(u, v) = camera.ray(part.u + u, part.v + v);
  return Camera::ray_table(std::move(rays), std::nullopt);
}

}  // namespace

ViewPart part_with_samples(const RangeView& view, int margin) {
  int u0 = view.width(), v0 = view.height(), u1 = -1, v1 = -1;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      u0 = std::min(u0, u), u1 = std::max(u1, u);
      v0 = std::min(v0, v), v1 = v;
    }
  if (u1 < 0) return {};
  u0 = std::max(u0 - margin, 0) / kBlock * kBlock, u1 = std::min(u1 + margin, view.width() - 1);
  v0 = std::max(v0 - margin, 0) / kBlock * kBlock, v1 = std::min(v1 + margin, view.height() - 1);
  return {u0, v0, u1 - u0 + 1, v1 - v0 + 1};
}

ViewPart part_to_refine(const RangeView& view) {
  const ViewPart part = part_with_samples(view, kMargin);
  const auto most = static_cast<std::size_t>(kMasked * static_cast<double>(view.range.size()));
  if (part.pixels() == 0 || part.pixels() > most) return {0, 0, view.width(), view.height()};
  return part;
}

RangeView crop(const RangeView& view, const ViewPart& part) {
  RangeView cropped;
  cropped.name = view.name;
  cropped.camera = crop(view.camera, part);
  cropped.range = crop(view.range, part);
  cropped.normals = crop(view.normals, part);
  cropped.confidence = crop(view.confidence, part);
  cropped.deviation = crop(view.deviation, part);
  cropped.colours = crop(view.colours, part);
  cropped.world_from_view = view.world_from_view;
  cropped.pose = view.pose;
  cropped.samples = view.samples;
  return cropped;
}

RangeView with_part(const RangeView& whole, const ViewPart& part, RangeView refined) {
  constexpr auto kUnknown = static_cast<float>(kNoSample);
  refined.camera = whole.camera;
  refined.range = within(whole, whole.range, kNoSample, part, refined.range);
  refined.normals = within(whole, whole.normals, Eigen::Vector3f::Constant(kUnknown).eval(), part,
                           refined.normals);
  refined.confidence = within(whole, whole.confidence, 1.0f, part, refined.confidence);
  refined.deviation = within(whole, {}, kUnknown, part, refined.deviation);
  refined.colours = within(whole, whole.colours, Colour{}, part, refined.colours);
  return refined;
}

}  // namespace relief::hybrid
