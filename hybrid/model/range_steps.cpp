#include "hybrid/model/range_steps.h"

#include "hybrid/model/slope_constraints.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

RangeSteps::Direction empty_direction(const RangeView& view) {
  const Grid<float> none(view.width(), view.height(), static_cast<float>(kNoSample));
  return {none, none, none, 1};
}

void measure_edge(const RangeView& view, int u, int v, int du, int dv,
                  RangeSteps::Direction& steps) {
  const std::optional<RangeStep> step = range_step(view, u, v, du, dv);
  if (!step) return;
  steps.expected(u, v) = static_cast<float>(step->expected);
  steps.discrepancy(u, v) = static_cast<float>(step->discrepancy);
  steps.sensitivity(u, v) = static_cast<float>(step->sensitivity);
}

}  // namespace

std::optional<RangeStep> range_step(const RangeView& view, int u, int v, int du, int dv) {
  if (!view.has_normal(u, v) || !view.has_normal(u + du, v + dv)) return std::nullopt;
  const Eigen::Vector3d normal =
      0.5 * (view.normals(u, v) + view.normals(u + du, v + dv)).cast<double>();
  const Ray tail = view.camera.ray(u, v), head = view.camera.ray(u + du, v + dv);
  const double t_tail = view.range(u, v), t_head = view.range(u + du, v + dv);
  const Eigen::Vector3d viewing = (tail.direction + head.direction).normalized();
  const double cosine = -normal.dot(viewing);
  if (!(cosine > kEdgeOnCosine)) return std::nullopt;

  const double t = 0.5 * (t_tail + t_head);
  const Eigen::Vector3d across = head.at(t) - tail.at(t);
  const double metric = 0.5 * (tail.direction.norm() + head.direction.norm());
  const double expected = normal.dot(across) / cosine;
  return RangeStep{expected, metric * (t_head - t_tail) - expected,
                   surface_step(tail, head, t, normal).norm() / cosine, cosine / normal.norm()};
}

RangeSteps range_steps(const RangeView& view, const GridEdges& edges) {
  RangeSteps steps{empty_direction(view), empty_direction(view)};
  if (!view.has_normals()) return steps;
  const auto measure_row = [&](int v) {
    for (int u = 0; u < view.width(); ++u) {
      if (edges.connected(u, v, 1, 0)) measure_edge(view, u, v, 1, 0, steps.along_rows);
      if (edges.connected(u, v, 0, 1)) measure_edge(view, u, v, 0, 1, steps.along_columns);
    }
  };
  parallel_for(static_cast<std::size_t>(view.height()), 16,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t v = begin; v < end; ++v) measure_row(static_cast<int>(v));
               });
  return steps;
}

}  // namespace relief::hybrid
