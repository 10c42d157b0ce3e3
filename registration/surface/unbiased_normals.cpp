#include "registration/surface/unbiased_normals.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

namespace relief::registration {

namespace {

constexpr int kLeastRadius = 4;  // [pixels]
// [pixels] It averages noise of one spacing to less than the next: sqrt(2) / 49^1.5 = 0.0041.
constexpr int kLargestRadius = 24;
constexpr double kWantedSlopeNoise = 0.0044;  // [rad], a quarter of a degree
constexpr double kLeastFilling = 0.25;  // Fraction of the window, by edges in either direction.

// What the edges of a window in one grid direction sum up to: how far the positions rise out of
// the planes of the normals, the steps themselves, and their number.
struct EdgeSum {
  double rise = 0.0;
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  double count = 0.0;

  EdgeSum& operator+=(const EdgeSum& other) {
    rise += other.rise;
    step += other.step;
    count += other.count;
    return *this;
  }
  EdgeSum& operator-=(const EdgeSum& other) {
    rise -= other.rise;
    step -= other.step;
    count -= other.count;
    return *this;
  }
};

// Sums over all pixels above and to the left, one row and column larger than the view, so that any
// window is the difference of four entries.
Grid<EdgeSum> cumulative_sums(const RangeView& view, const GridEdges& edges, int du, int dv) {
  Grid<EdgeSum> sums(view.width() + 1, view.height() + 1);
  for (int v = 0; v < view.height(); ++v) {
    EdgeSum row;
    for (int u = 0; u < view.width(); ++u) {
      if (edges.connected(u, v, du, dv) && view.has_normal(u, v) &&
          view.has_normal(u + du, v + dv)) {
        const Eigen::Vector3d step = view.point(u + du, v + dv) - view.point(u, v);
        const Eigen::Vector3d normal =
            (0.5f * (view.normals(u, v) + view.normals(u + du, v + dv))).cast<double>();
        row += {normal.dot(step), step, 1.0};
      }
      sums(u + 1, v + 1) = sums(u + 1, v);
      sums(u + 1, v + 1) += row;
    }
  }
  return sums;
}

EdgeSum window_sum(const Grid<EdgeSum>& sums, int u, int v, int radius) {
  const int left = std::max(0, u - radius), right = std::min(sums.width() - 1, u + radius + 1);
  const int top = std::max(0, v - radius), bottom = std::min(sums.height() - 1, v + radius + 1);
  EdgeSum sum = sums(right, bottom);
  sum -= sums(left, bottom);
  sum -= sums(right, top);
  sum += sums(left, top);
  return sum;
}

// The mean slope over a window is known from the noisy positions at its two ends only.
double noise_of_slope(const UnbiasedNormalOptions& options, int radius) {
  const double side = 2.0 * radius + 1.0;
  return std::sqrt(2.0) * options.noise / (options.spacing * std::pow(side, 1.5));
}

int radius_for(const UnbiasedNormalOptions& options) {
  if (options.radius > 0) return options.radius;
  int radius = kLeastRadius;
  while (radius < kLargestRadius && options.spacing > 0.0 &&
         noise_of_slope(options, radius) > kWantedSlopeNoise)
    ++radius;
  return radius;
}

// (R8): the change b of the normal within its plane that takes up the mean rises along both mean
// steps, b . s_u = e_u, b . s_v = e_v, b . n = 0, is taken off.
Eigen::Vector3d without_bias(const Eigen::Vector3d& normal, const EdgeSum& along_u,
                             const EdgeSum& along_v) {
  const Eigen::Vector3d step_u = along_u.step / along_u.count;
  const Eigen::Vector3d step_v = along_v.step / along_v.count;
  const double volume = normal.dot(step_u.cross(step_v));
  const Eigen::Vector3d bias = (along_u.rise / along_u.count * step_v.cross(normal) +
                                along_v.rise / along_v.count * normal.cross(step_u)) /
                               volume;
  return (normal - bias).normalized();
}

}  // namespace

Grid<Eigen::Vector3f> unbiased_normals(const RangeView& view, const GridEdges& edges,
                                       const UnbiasedNormalOptions& options) {
  Grid<Eigen::Vector3f> result(view.width(), view.height(),
                               Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
  if (!view.has_normals()) return result;
  const int radius = radius_for(options);
  const double least = kLeastFilling * (2 * radius + 1) * (2 * radius + 1);
  const auto sums_u = cumulative_sums(view, edges, 1, 0);
  const auto sums_v = cumulative_sums(view, edges, 0, 1);
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v) || !view.has_normal(u, v)) continue;
      const EdgeSum along_u = window_sum(sums_u, u, v, radius);
      const EdgeSum along_v = window_sum(sums_v, u, v, radius);
      if (std::min(along_u.count, along_v.count) < least) continue;
      result(u, v) =
          without_bias(view.normals(u, v).cast<double>(), along_u, along_v).cast<float>();
    }
  }
  return result;
}

}  // namespace relief::registration
