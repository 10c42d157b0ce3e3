#include "hybrid/slope_constraints.h"

#include <optional>

namespace relief {

namespace {

// Beyond this incidence (cosine) a normal says next to nothing about the range, and its error turns
// the sign of the constraint's coefficients.
constexpr double kEdgeOnCosine = 0.02;

std::uint32_t grid_index(const RangeView& view, int u, int v) {
  return static_cast<std::uint32_t>(view.range.index(u, v));
}

struct Pixel {
  int u, v;
};

std::optional<SlopeConstraint> constraint_between(const RangeView& view, Pixel tail, Pixel head,
                                                  Pixel at0, Pixel at1) {
  if (!view.has_normal(at0.u, at0.v) || !view.has_normal(at1.u, at1.v)) return std::nullopt;
  const Eigen::Vector3d normal =
      0.5 * (view.normals(at0.u, at0.v) + view.normals(at1.u, at1.v)).cast<double>();
  const Ray tail_ray = view.camera.ray(tail.u, tail.v), head_ray = view.camera.ray(head.u, head.v);
  const double t_tail = view.range(tail.u, tail.v), t_head = view.range(head.u, head.v);

  SlopeConstraint constraint;
  constraint.tail = grid_index(view, tail.u, tail.v);
  constraint.head = grid_index(view, head.u, head.v);
  constraint.at = {grid_index(view, at0.u, at0.v), grid_index(view, at1.u, at1.v)};
  const auto along = [&](const Eigen::Vector3d& v) { return static_cast<float>(normal.dot(v)); };
  constraint.step = along(head_ray.at(t_head) - tail_ray.at(t_tail));
  constraint.tail_slope = along(tail_ray.direction.normalized());
  constraint.head_slope = along(head_ray.direction.normalized());
  if (constraint.tail_slope > -kEdgeOnCosine || constraint.head_slope > -kEdgeOnCosine)
    return std::nullopt;
  constraint.length =
      static_cast<float>(surface_step(tail_ray, head_ray, 0.5 * (t_tail + t_head), normal).norm());
  return constraint.length > 0.0f ? std::optional(constraint) : std::nullopt;
}

std::optional<SlopeConstraint> compact_constraint(const RangeView& view, const GridEdges& edges,
                                                  Pixel p, int du, int dv) {
  if (!edges.connected(p.u, p.v, du, dv)) return std::nullopt;
  const Pixel q{p.u + du, p.v + dv};
  return constraint_between(view, p, q, p, q);
}

// Two-sided where both neighbours are on the surface, one-sided at boundaries; halved when
// two-sided, so that a residual belongs to one sample spacing.
std::optional<SlopeConstraint> central_constraint(const RangeView& view, const GridEdges& edges,
                                                  Pixel p, int du, int dv) {
  const bool before = edges.connected(p.u, p.v, -du, -dv);
  const bool after = edges.connected(p.u, p.v, du, dv);
  if (!before && !after) return std::nullopt;
  const Pixel tail = before ? Pixel{p.u - du, p.v - dv} : p;
  const Pixel head = after ? Pixel{p.u + du, p.v + dv} : p;
  auto constraint = constraint_between(view, tail, head, p, p);
  if (!constraint || !before || !after) return constraint;
  for (float* term :
       {&constraint->step, &constraint->tail_slope, &constraint->head_slope, &constraint->length})
    *term *= 0.5f;
  return constraint;
}

}  // namespace

Eigen::Vector3d surface_step(const Ray& tail, const Ray& head, double t,
                             const Eigen::Vector3d& normal) {
  const Eigen::Vector3d across = head.at(t) - tail.at(t);
  const Eigen::Vector3d viewing = tail.direction.normalized() + head.direction.normalized();
  return across - viewing * (normal.dot(across) / normal.dot(viewing));
}

std::vector<SlopeConstraint> slope_constraints(const RangeView& view, const GridEdges& edges,
                                               Stencil stencil) {
  const auto make = stencil == Stencil::kCompactEdge ? compact_constraint : central_constraint;
  std::vector<SlopeConstraint> constraints;
  if (!view.has_normals()) return constraints;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      for (const int axis : {0, 1}) {
        auto constraint = make(view, edges, {u, v}, axis == 0, axis == 1);
        if (!constraint) continue;
        constraint->axis = axis;
        constraints.push_back(*constraint);
      }
    }
  }
  return constraints;
}

}  // namespace relief
