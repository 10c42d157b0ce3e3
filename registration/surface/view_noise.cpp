#include "registration/surface/view_noise.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "registration/pairwise/robust.h"
#include "scan/grid/grid_normals.h"

namespace relief::registration {

namespace {

// Normals that the noise is measured at: it need not be looked for everywhere. 5000 tell it to 2 %
// (1.17 / sqrt(n)).
constexpr double kNoiseNormals = 5000.0;
constexpr int kMostStride = 8;  // [pixels]

int stride_for(const RangeView& view) {
  const double step = std::sqrt(static_cast<double>(view.sample_count()) / kNoiseNormals);
  return std::clamp(static_cast<int>(step), 1, kMostStride);
}

// Third differences of the range along (du, dv), turned into distances along the normal and scaled
// to the standard deviation of one sample: (1, -3, 3, -1) has variance 20 sigma^2. A surface that
// is quadratic over four samples contributes nothing.
void third_differences(const RangeView& view, const GridEdges& edges,
                       const Grid<Eigen::Vector3f>& normals, int stride, int du, int dv,
                       std::vector<double>& out) {
  for (int v = 0; v + 3 * dv < view.height(); v += stride) {
    for (int u = 0; u + 3 * du < view.width(); u += stride) {
      bool connected = normals(u, v).allFinite();
      for (int k = 0; k < 3 && connected; ++k)
        connected = edges.connected(u + k * du, v + k * dv, du, dv);
      if (!connected) continue;
      const auto t = [&](int k) { return view.range(u + k * du, v + k * dv); };
      const double along_normal = view.camera.ray(u, v).direction.dot(normals(u, v).cast<double>());
      out.push_back((t(0) - 3 * t(1) + 3 * t(2) - t(3)) * along_normal / std::sqrt(20.0));
    }
  }
}

}  // namespace

double position_noise(const RangeView& view, const ConnectedGrid& grid, const RangeNoise& noise) {
  const int stride = stride_for(view);
  const auto normals = estimate_normals(view, grid, {.stride = stride, .noise = &noise});
  std::vector<double> differences;
  third_differences(view, grid.edges, normals, stride, 1, 0, differences);
  third_differences(view, grid.edges, normals, stride, 0, 1, differences);
  return robust_sigma(std::move(differences));
}

double slope_noise(double noise, double spacing, int radius) {
  // sigma / (spacing sqrt(sum of u^2 over the window)).
  const double side = 2.0 * radius + 1.0;
  const double moment = side * side * radius * (radius + 1.0) / 3.0;
  return spacing > 0.0 ? noise / (spacing * std::sqrt(moment)) : 0.0;
}

double noise_ratio(const RangeView& view, const RangeNoise& ranges) {
  if (ranges.map.empty() || !ranges.known()) return 1.0;
  double squares = 0.0, count = 0.0;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v) && !ranges.is_too_noisy(u, v))
        squares += std::pow(ranges.sigma_at(u, v), 2), count += 1.0;
  return count > 0.0 ? std::max(1.0, std::sqrt(squares / count) / ranges.sigma) : 1.0;
}

double typical_incidence(const RangeView& view, const Grid<Eigen::Vector3f>& normals) {
  std::vector<double> cosines;
  for (int v = 0; v < view.height(); v += 4)
    for (int u = 0; u < view.width(); u += 4)
      if (normals(u, v).allFinite())
        cosines.push_back(std::abs(
            view.camera.ray(u, v).direction.normalized().dot(normals(u, v).cast<double>())));
  return cosines.empty() ? 1.0 : quantile(std::move(cosines), 0.5);
}

double typical_step(const RangeView& view, const RangeNoise& noise) {
  if (!noise.quantisation.exists()) return 0.0;
  double squares = 0.0, count = 0.0;
  for (int v = 0; v < view.height(); v += 4) {
    for (int u = 0; u < view.width(); u += 4) {
      if (!view.has_sample(u, v)) continue;
      const double length = view.camera.ray(u, v).direction.norm();
      const double step = noise.quantisation.step_at(view.range(u, v), length);
      if (step <= kLargestNoiseRatio * noise.step) squares += step * step, count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(squares / count) : 0.0;
}

}  // namespace relief::registration
