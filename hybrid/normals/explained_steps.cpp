#include "hybrid/normals/explained_steps.h"

#include <cmath>
#include <numbers>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr double kDeviations = 3.0;
// Cosine of incidence below which a normal explains any step.
constexpr double kEdgeOn = 0.14;  // The 8 degrees of DiscontinuityOptions::grazing_angle_deg.

bool explained(const RangeView& view, int u, int v, int du, int dv, double sigma) {
  const int x = u + du, y = v + dv;
  if (!view.has_sample(u, v) || !view.has_sample(x, y)) return false;
  if (!view.has_normal(u, v) || !view.has_normal(x, y)) return false;
  const Ray tail = view.camera.ray(u, v), head = view.camera.ray(x, y);
  const double t_tail = view.range(u, v), t_head = view.range(x, y), t = 0.5 * (t_tail + t_head);
  const Eigen::Vector3d viewing = (tail.direction + head.direction).normalized();
  const Eigen::Vector3d across = head.at(t) - tail.at(t);
  const Eigen::Vector3d normal = (view.normals(u, v) + view.normals(x, y)).cast<double>();
  const double cosine = -normal.normalized().dot(viewing);
  if (!(cosine > kEdgeOn)) return false;
  const double expected = -normal.dot(across) / normal.dot(viewing);
  const double step = 0.5 * (tail.direction.norm() + head.direction.norm()) * (t_head - t_tail);
  const double noise = kDeviations * std::numbers::sqrt2 * sigma;
  return std::abs(step - expected) <= noise;
}

}  // namespace

void connect_explained_steps(const RangeView& view, double sigma, int threads, GridEdges& edges) {
  if (!view.has_normals()) return;
  parallel_rows(view.height(), threads, [&](int v) {
    for (int u = 0; u < view.width(); ++u) {
      if (u + 1 < view.width() && !edges.right(u, v) && explained(view, u, v, 1, 0, sigma))
        edges.right(u, v) = 1;
      if (v + 1 < view.height() && !edges.down(u, v) && explained(view, u, v, 0, 1, sigma))
        edges.down(u, v) = 1;
    }
  });
}

}  // namespace relief::hybrid
