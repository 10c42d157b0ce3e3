#include "fusion/views/paged_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "relief/scan/discontinuities.h"
#include "scan/base/median.h"
#include "scan/base/median_deviation.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/filled_view.h"
#include "scan/grid/grid_normals.h"
#include "scan/grid/range_noise.h"
#include "scan/surface/range_surface.h"

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

// Takes the normals from patches of fewer than `smallest` connected samples.
void leave_out_small_patches(const RangeView& view, const GridEdges& edges, int smallest,
                             Grid<Eigen::Vector3f>& normals) {
  Grid<std::uint8_t> visited(view.width(), view.height(), 0);
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
      if (patch.size() >= static_cast<std::size_t>(smallest)) continue;
      for (const auto& [pu, pv] : patch)
        normals(pu, pv).setConstant(std::numeric_limits<float>::quiet_NaN());
    }
  }
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
  return kSigmaPerMedian * median(deviations) / std::sqrt(1.25);
}

// Crops the surface to its quads and marks them.
void place_quads(const RangeSurface& range, const Grid<std::uint8_t>& noisy, MemoryLimit* memory,
                 PagedSurface& surface) {
  int u0 = range.width(), v0 = range.height(), u1 = -1, v1 = -1;
  range.for_each_sample([&](int u, int v) {
    if (!range.has_quad(u, v)) return;
    u0 = std::min(u0, u), u1 = std::max(u1, u + 1);
    v0 = std::min(v0, v), v1 = std::max(v1, v + 1);
  });
  if (u1 < 0) return;
  surface.first_u = u0;
  surface.first_v = v0;
  surface.pixels = PagedGrid<SurfacePixel>(u1 - u0 + 1, v1 - v0 + 1, memory);
  surface.marks = PagedGrid<std::uint8_t>(u1 - u0 + 1, v1 - v0 + 1, memory);
  for (int v = v0; v < v1; ++v) {
    for (int u = u0; u < u1; ++u) {
      if (!range.has_quad(u, v)) continue;
      const bool measured =
          !(noisy(u, v) || noisy(u + 1, v) || noisy(u, v + 1) || noisy(u + 1, v + 1));
      surface.marks(u - u0, v - v0) |= measured ? kQuad : kQuad | kNoisyQuad;
      for (int k = 0; k < 4; ++k)
        surface.marks(u - u0 + (k & 1), v - v0 + (k >> 1)) |=
            measured ? kCorner | kMeasuredCorner : kCorner;
    }
  }
}

// 1 for the noisy samples, see PagedSurface. Precise scanners have samples of ten times the typical
// noise, too, that still place a surface far better than closing would; so do grazing rays. Normals
// that are estimated from noisy ranges are noise themselves: the noise along the ray counts there.
Grid<std::uint8_t> noisy_samples(const RangeView& view, const RangeNoise& noise, double spacing) {
  const double known = median_deviation(view);
  const double most = std::max(kLargestNoiseRatio * (known > 0.0 ? known : noise.sigma), spacing);
  const auto stddev = [&](int u, int v) {
    const double along_ray = known > 0.0 ? view.deviation_at(u, v) : noise.sigma_at(u, v);
    if (!(along_ray > most) || !view.has_normal(u, v)) return along_ray;
    return along_ray * std::abs(view.camera.ray(u, v).direction.normalized().dot(
                           view.normals(u, v).cast<double>()));
  };
  Grid<std::uint8_t> noisy(view.width(), view.height(), 0);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      noisy(u, v) = view.has_sample(u, v) && stddev(u, v) > most;
  return noisy;
}

// Those of the samples with confidence that were measured, are not noisy, and are no corner.
PagedArray<std::array<float, 3>> scattered_samples(const FilledView& filled,
                                                   const Grid<std::uint8_t>& noisy,
                                                   const PagedSurface& surface,
                                                   MemoryLimit* memory) {
  const RangeView& view = filled.view;
  const auto is_corner = [&](int u, int v) {
    u -= surface.first_u, v -= surface.first_v;
    return u >= 0 && v >= 0 && u < surface.marks.width() && v < surface.marks.height() &&
           surface.corner(u, v);
  };
  const auto for_scattered = [&](const auto& visit) {
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        if (view.has_sample(u, v) && !filled.filled(u, v) && !noisy(u, v) &&
            view.confidence_at(u, v) > 0.0f && !is_corner(u, v))
          visit(u, v);
  };
  std::size_t count = 0;
  for_scattered([&](int, int) { ++count; });
  PagedArray<std::array<float, 3>> scattered(count, memory);
  std::size_t next = 0;
  for_scattered([&](int u, int v) {
    const Eigen::Vector3f offset = (view.point(u, v) - surface.centre).cast<float>();
    scattered[next++] = {offset.x(), offset.y(), offset.z()};
  });
  return scattered;
}

}  // namespace

PagedSurface surface_of(const RangeView& measured, const PagedSurfaceOptions& options) {
  const FilledView filled = fill_small_gaps(measured);
  const RangeView& view = filled.view;
  const RangeNoise noise = estimate_range_noise(view);
  const ConnectedGrid grid = connect_grid(view, noise);
  Grid<Eigen::Vector3f> normals = surface_normals(view, grid);
  PagedSurface surface;
  surface.flying = filled.flying;
  surface.filled = filled.filled_count;
  surface.noise = position_noise(grid, normals);
  leave_out_small_patches(view, grid.edges, options.smallest_patch, normals);
  const RangeSurface range(view, grid, normals,
                           observation_weights(view, grid, normals, options.weights));
  surface.spacing = range.spacing();
  const Grid<std::uint8_t> noisy = noisy_samples(view, noise, surface.spacing);
  surface.noisy = static_cast<std::size_t>(std::count(noisy.begin(), noisy.end(), 1));
  place_quads(range, noisy, options.memory, surface);

  std::size_t corners = 0;
  const auto for_corners = [&](const auto& visit) {
    for (int v = 0; v < surface.pixels.height(); ++v)
      for (int u = 0; u < surface.pixels.width(); ++u)
        if (surface.corner(u, v))
          visit(u + surface.first_u, v + surface.first_v, surface.pixels(u, v));
  };
  for_corners([&](int u, int v, const SurfacePixel&) {
    surface.centre += range.point(u, v);
    ++corners;
  });
  if (corners > 0) surface.centre /= static_cast<double>(corners);
  for_corners([&](int u, int v, SurfacePixel& pixel) {
    const Eigen::Vector3f point = (range.point(u, v) - surface.centre).cast<float>();
    const Eigen::Vector3f& normal = normals(u, v);  // Unrounded: a part of (F1).
    pixel = {{point.x(), point.y(), point.z()},
             static_cast<float>(range.weight(u, v)),
             {normal.x(), normal.y(), normal.z()},
             static_cast<float>(range.boundary_distance(u, v))};
  });
  surface.scattered = scattered_samples(filled, noisy, surface, options.memory);
  if (view.colours.empty()) return surface;
  surface.colours =
      PagedGrid<Colour>(surface.pixels.width(), surface.pixels.height(), options.memory);
  for (int v = 0; v < surface.colours.height(); ++v)
    for (int u = 0; u < surface.colours.width(); ++u)
      surface.colours(u, v) = view.colours(u + surface.first_u, v + surface.first_v);
  return surface;
}

}  // namespace relief::fusion
