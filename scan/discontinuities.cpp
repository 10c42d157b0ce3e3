#include "scan/discontinuities.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "scan/median.h"
#include "scan/parallel.h"

namespace relief {

namespace {

// The step from sample (u,v) to (u+du,v+dv) along the ray, in units of the lateral distance between
// the two rays at the nearer sample; NaN unless both have a sample. 1 is a slope of 45 degrees.
double relative_step(const RangeView& view, int u, int v, int du, int dv) {
  if (!view.has_sample(u, v) || !view.has_sample(u + du, v + dv)) return kNoSample;
  const Ray a = view.camera.ray(u, v), b = view.camera.ray(u + du, v + dv);
  const Eigen::Vector3d viewing = a.direction + b.direction;
  const Eigen::Vector3d edge = b.at(view.range(u + du, v + dv)) - a.at(view.range(u, v));
  const double t_near = std::min(view.range(u, v), view.range(u + du, v + dv));
  const Eigen::Vector3d across = b.at(t_near) - a.at(t_near);
  // Both components of what is not normalised have the length of `viewing` as factor.
  const double along = across.dot(viewing);
  const double lateral = std::sqrt(across.squaredNorm() * viewing.squaredNorm() - along * along);
  return lateral > 0.0 ? edge.dot(viewing) / lateral : kNoSample;
}

Grid<float> relative_steps(const RangeView& view, int du, int dv, int threads) {
  Grid<float> steps(view.width(), view.height(), static_cast<float>(kNoSample));
  parallel_rows(std::max(0, view.height() - dv), threads, [&](int v) {
    for (int u = 0; u + du < view.width(); ++u)
      steps(u, v) = static_cast<float>(relative_step(view, u, v, du, dv));
  });
  return steps;
}

// Robust standard deviation of one step: the median absolute difference of successive steps, which
// has variance 6 sigma_p^2 for white noise against 2 sigma_p^2 of a step.
double step_noise(const Grid<float>& steps, int du, int dv) {
  std::vector<float> differences;
  for (int v = 0; v + dv < steps.height(); ++v) {
    for (int u = 0; u + du < steps.width(); ++u) {
      const float difference = std::abs(steps(u + du, v + dv) - steps(u, v));
      if (difference == difference) differences.push_back(difference);
    }
  }
  return 1.4826 * median(differences) / std::numbers::sqrt3;
}

Grid<std::uint8_t> connect_direction(const RangeView& view, int du, int dv,
                                     const DiscontinuityOptions& options, int threads) {
  const Grid<float> steps = relative_steps(view, du, dv, threads);
  const double limit = 1.0 / std::tan(options.grazing_angle_deg * std::numbers::pi / 180.0);
  const double free_step =
      std::min(limit, std::max(options.free_step, 4.0 * step_noise(steps, du, dv)));
  // A neighbouring step explains this one when they differ by less than half of it.
  const auto alike = [&](int u, int v, float step) {
    return steps.contains(u, v) && std::abs(steps(u, v) - step) <= 0.5f * std::abs(step);
  };
  Grid<std::uint8_t> connected(view.width(), view.height(), 0);
  parallel_rows(view.height(), threads, [&](int v) {
    for (int u = 0; u < view.width(); ++u) {
      const float step = steps(u, v);
      if (!(std::abs(step) <= limit)) continue;
      connected(u, v) =
          std::abs(step) <= free_step || alike(u - du, v - dv, step) || alike(u + du, v + dv, step);
    }
  });
  return connected;
}

}  // namespace

GridEdges connect_samples(const RangeView& view, const DiscontinuityOptions& options, int threads) {
  return {connect_direction(view, 1, 0, options, threads),
          connect_direction(view, 0, 1, options, threads)};
}

Grid<std::uint8_t> boundary_distance(const RangeView& view, const GridEdges& edges) {
  const int width = view.width(), height = view.height();
  // Pixels on the border of the grid have distance 0, so the others have all their neighbours.
  Grid<std::uint8_t> distance(width, height, 0);
  for (int v = 1; v + 1 < height; ++v)
    for (int u = 1; u + 1 < width; ++u)
      if (edges.right(u, v) && edges.right(u - 1, v) && edges.down(u, v) && edges.down(u, v - 1))
        distance(u, v) = 255;
  const auto relax = [&](int u, int v, int du, int dv) {
    const int next = distance(u + du, v + dv) + 1;
    distance(u, v) = static_cast<std::uint8_t>(std::min<int>(distance(u, v), next));
  };
  for (int v = 1; v + 1 < height; ++v)
    for (int u = 1; u + 1 < width; ++u)
      if (distance(u, v) > 0)
        for (const auto& [du, dv] : {std::pair{-1, 0}, {-1, -1}, {0, -1}, {1, -1}})
          relax(u, v, du, dv);
  for (int v = height - 2; v >= 1; --v)
    for (int u = width - 2; u >= 1; --u)
      if (distance(u, v) > 0)
        for (const auto& [du, dv] : {std::pair{1, 0}, {1, 1}, {0, 1}, {-1, 1}}) relax(u, v, du, dv);
  return distance;
}

ConnectedGrid connect_grid(const RangeView& view, int threads) {
  ConnectedGrid grid;
  grid.points = points_of(view);
  grid.edges = connect_samples(view, {}, threads);
  grid.boundary = boundary_distance(view, grid.edges);
  return grid;
}

}  // namespace relief
