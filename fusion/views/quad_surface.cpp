#include "fusion/views/quad_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "relief/scan/discontinuities.h"
#include "scan/base/median.h"
#include "scan/base/silhouette_weight.h"
#include "scan/grid/filled_view.h"
#include "scan/grid/grid_normals.h"

namespace relief::fusion {

namespace {

// The measured normal where there is one, else that of the measured surface.
Grid<Eigen::Vector3f> surface_normals(const RangeView& view, const ConnectedGrid& grid) {
  const auto lacks_one = [&](int u, int v) {
    return view.has_sample(u, v) && !view.has_normal(u, v);
  };
  bool any = false;
  for (int v = 0; v < view.height() && !any; ++v)
    for (int u = 0; u < view.width() && !any; ++u) any = lacks_one(u, v);
  if (!any) return view.normals;
  GridNormalOptions options;
  Grid<Eigen::Vector3f> normals = estimate_normals(view, grid, options);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_normal(u, v)) normals(u, v) = view.normals(u, v);
  return normals;
}

constexpr std::array<std::pair<int, int>, 4> kNeighbours{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

// 1 for samples of patches of at least `smallest` connected samples.
Grid<std::uint8_t> in_large_patch(const RangeView& view, const GridEdges& edges, int smallest) {
  Grid<std::uint8_t> large(view.width(), view.height(), 0), visited = large;
  std::vector<std::pair<int, int>> patch;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (visited(u, v) || !view.has_sample(u, v)) continue;
      visited(u, v) = 1;
      patch.assign(1, {u, v});
      for (std::size_t next = 0; next < patch.size(); ++next) {
        const auto [pu, pv] = patch[next];
        for (const auto& [du, dv] : kNeighbours) {
          if (!edges.connected(pu, pv, du, dv) || visited(pu + du, pv + dv)) continue;
          visited(pu + du, pv + dv) = 1;
          patch.emplace_back(pu + du, pv + dv);
        }
      }
      if (patch.size() < static_cast<std::size_t>(smallest)) continue;
      for (const auto& [pu, pv] : patch) large(pu, pv) = 1;
    }
  }
  return large;
}

// For white noise the distance between a sample and the mean of its four neighbours has variance
// (1 + 1/4) sigma^2. Curvature adds to it, so this errs on the large side.
double position_noise(const ConnectedGrid& grid, const Grid<Eigen::Vector3f>& normals) {
  const auto& [points, edges, border] = grid;
  std::vector<double> deviations;
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (!(edges.connected(u, v, 1, 0) && edges.connected(u, v, -1, 0) &&
            edges.connected(u, v, 0, 1) && edges.connected(u, v, 0, -1)))
        continue;
      const Eigen::Vector3d mean =
          0.25 * (points(u + 1, v) + points(u - 1, v) + points(u, v + 1) + points(u, v - 1));
      const double deviation = std::abs(normals(u, v).cast<double>().dot(points(u, v) - mean));
      if (std::isfinite(deviation)) deviations.push_back(deviation);
    }
  }
  return 1.4826 * median(deviations) / std::sqrt(1.25);
}

// 1 at the upper left corner of each quad.
Grid<std::uint8_t> find_quads(const RangeView& view, const GridEdges& edges,
                              const Grid<Eigen::Vector3f>& normals, int smallest_patch) {
  Grid<std::uint8_t> sound = in_large_patch(view, edges, smallest_patch);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      sound(u, v) = sound(u, v) && normals(u, v).allFinite() && view.confidence_at(u, v) > 0.0f;
  Grid<std::uint8_t> quads(view.width(), view.height(), 0);
  for (int v = 0; v + 1 < view.height(); ++v)
    for (int u = 0; u + 1 < view.width(); ++u)
      quads(u, v) = edges.connected_quad(u, v) && sound(u, v) && sound(u + 1, v) &&
                    sound(u, v + 1) && sound(u + 1, v + 1);
  return quads;
}

// Crops the surface to its quads and marks them.
void place_quads(const Grid<std::uint8_t>& quads, MemoryLimit* memory, QuadSurface& surface) {
  int u0 = quads.width(), v0 = quads.height(), u1 = -1, v1 = -1;
  for (int v = 0; v < quads.height(); ++v) {
    for (int u = 0; u < quads.width(); ++u) {
      if (!quads(u, v)) continue;
      u0 = std::min(u0, u), u1 = std::max(u1, u + 1);
      v0 = std::min(v0, v), v1 = std::max(v1, v + 1);
    }
  }
  if (u1 < 0) return;
  surface.first_u = u0;
  surface.first_v = v0;
  surface.pixels = PagedGrid<SurfacePixel>(u1 - u0 + 1, v1 - v0 + 1, memory);
  surface.marks = PagedGrid<std::uint8_t>(u1 - u0 + 1, v1 - v0 + 1, memory);
  for (int v = v0; v < v1; ++v) {
    for (int u = u0; u < u1; ++u) {
      if (!quads(u, v)) continue;
      surface.marks(u - u0, v - v0) |= kQuad;
      for (int k = 0; k < 4; ++k) surface.marks(u - u0 + (k & 1), v - v0 + (k >> 1)) |= kCorner;
    }
  }
}

float sample_weight(const RangeView& view, int u, int v, const Eigen::Vector3f& normal, int border,
                    const QuadSurfaceOptions& options) {
  constexpr double kLeastCosine = 0.05;  // 87 degrees; keeps weights positive.
  const double cosine = std::max(
      kLeastCosine, -normal.cast<double>().dot(view.camera.ray(u, v).direction.normalized()));
  double trust = view.confidence_at(u, v);
  if (options.nominal_deviation > 0.0 && view.deviation_at(u, v) > 0.0f)
    trust = std::pow(options.nominal_deviation / (cosine * view.deviation_at(u, v)), 2);
  return static_cast<float>(trust * cosine * silhouette_weight(border, options.silhouette_ramp));
}

}  // namespace

QuadSurface surface_of(const RangeView& measured, const QuadSurfaceOptions& options) {
  const FilledView filled = fill_small_gaps(measured);
  const RangeView& view = filled.view;
  const ConnectedGrid grid = connect_grid(view);
  const auto& [points, edges, border] = grid;
  const Grid<Eigen::Vector3f> normals = surface_normals(view, grid);
  QuadSurface surface;
  surface.flying = filled.flying;
  surface.filled = filled.filled_count;
  surface.spacing = sample_spacing(points, edges);
  surface.noise = position_noise(grid, normals);
  place_quads(find_quads(view, edges, normals, options.smallest_patch), options.memory, surface);

  std::size_t corners = 0;
  const auto for_corners = [&](const auto& visit) {
    for (int v = 0; v < surface.pixels.height(); ++v)
      for (int u = 0; u < surface.pixels.width(); ++u)
        if (surface.corner(u, v))
          visit(u + surface.first_u, v + surface.first_v, surface.pixels(u, v));
  };
  for_corners([&](int u, int v, const SurfacePixel&) {
    surface.centre += points(u, v);
    ++corners;
  });
  if (corners > 0) surface.centre /= static_cast<double>(corners);
  for_corners([&](int u, int v, SurfacePixel& pixel) {
    const Eigen::Vector3f point = (points(u, v) - surface.centre).cast<float>();
    const Eigen::Vector3f& normal = normals(u, v);
    pixel = {{point.x(), point.y(), point.z()},
             sample_weight(view, u, v, normal, border(u, v), options),
             {normal.x(), normal.y(), normal.z()},
             static_cast<float>(border(u, v))};
  });
  if (view.colours.empty()) return surface;
  surface.colours =
      PagedGrid<Colour>(surface.pixels.width(), surface.pixels.height(), options.memory);
  for (int v = 0; v < surface.colours.height(); ++v)
    for (int u = 0; u < surface.colours.width(); ++u)
      surface.colours(u, v) = view.colours(u + surface.first_u, v + surface.first_v);
  return surface;
}

}  // namespace relief::fusion
