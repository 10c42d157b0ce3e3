#include "hybrid/model/slope_constraints.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kRowsAtOnce = 16;  // Of one piece of work; changes no result.

struct Pixel {
  int u, v;
};

struct Constraint {
  float step, tail_slope, head_slope, length;
};

// The trapezoidal rule (H4) errs by a twelfth of the length times the second difference of the
// slope, for long waves. The shorter they are, the more: 1.6 twelfths at 4 samples, 3.1 at 2.8.
constexpr double kOfSecondDifference = 3.0 / 12.0;

// A kink anywhere between the two samples has a third difference of twice its angle. The mean of
// the two slopes errs by the angle / sqrt(12), 0.144 of the difference: an eighth to 13 %.
constexpr double kOfThirdDifference = 1.0 / 8.0;

// No crease counts for more than this [rad]: the rim of a patch of wrong normals looks like one. At
// 1.5 degrees of noise such edges keep a sixth of their weight; at twice the value a twentieth.
constexpr double kMostOfCrease = 0.06;

// Variance of both together per variance of a normal: a quarter of (1, -1, -1, 1) / 2 and an eighth
// of (1, -3, 3, -1).
constexpr double kNoiseOfDifferences = 4.0 / (4.0 * 16.0) + 20.0 / 64.0;

// The error [rad] that the turning of the surface along the line through the compact constraint
// from p to q lets its slope have, from the normals of up to four samples.
double truncation_of(const RangeView& view, const GridEdges& edges, Pixel p, Pixel q) {
  const int du = q.u - p.u, dv = q.v - p.v;
  const auto normal = [&](Pixel x) { return view.normals(x.u, x.v).cast<double>().eval(); };
  const Eigen::Vector3d turn = normal(q) - normal(p), mean = (normal(q) + normal(p)).normalized();
  const Eigen::Vector3d step = view.point(q.u, q.v) - view.point(p.u, p.v);
  const Eigen::Vector3d tangent = (step - mean * mean.dot(step)).normalized();
  // How the turning changes from the step before to this one, or from this one to the next.
  const auto change = [&](Pixel end, int direction) -> std::optional<double> {
    const Pixel next{end.u + direction * du, end.v + direction * dv};
    if (!edges.connected(end.u, end.v, direction * du, direction * dv) ||
        !view.has_normal(next.u, next.v))
      return std::nullopt;
    return tangent.dot(direction * (normal(next) - normal(end)) - turn) * direction;
  };
  const std::optional<double> before = change(p, -1), after = change(q, 1);
  if (!before && !after) return 0.0;
  const double second = 0.5 * (before.value_or(*after) + after.value_or(*before));
  const double third = before && after ? *after - *before : second;
  const double crease = kMostOfCrease * std::tanh(kOfThirdDifference * third / kMostOfCrease);
  return std::hypot(kOfSecondDifference * second, crease);
}

std::optional<Constraint> constraint_between(const RangeView& view, Pixel tail, Pixel head,
                                             Pixel at0, Pixel at1) {
  if (!view.has_normal(at0.u, at0.v) || !view.has_normal(at1.u, at1.v)) return std::nullopt;
  const Eigen::Vector3d normal =
      0.5 * (view.normals(at0.u, at0.v) + view.normals(at1.u, at1.v)).cast<double>();
  const Ray tail_ray = view.camera.ray(tail.u, tail.v), head_ray = view.camera.ray(head.u, head.v);
  const double t_tail = view.range(tail.u, tail.v), t_head = view.range(head.u, head.v);

  const double tail_slope = normal.dot(tail_ray.direction.normalized());
  const double head_slope = normal.dot(head_ray.direction.normalized());
  if (tail_slope > -kEdgeOnCosine || head_slope > -kEdgeOnCosine) return std::nullopt;
  const double step = normal.dot(head_ray.at(t_head) - tail_ray.at(t_tail));
  const double length = surface_step(tail_ray, head_ray, 0.5 * (t_tail + t_head), normal).norm();
  if (!(length > 0.0)) return std::nullopt;
  return Constraint{static_cast<float>(step), static_cast<float>(tail_slope),
                    static_cast<float>(head_slope), static_cast<float>(length)};
}

std::optional<Constraint> compact_constraint(const RangeView& view, const GridEdges& edges, Pixel p,
                                             int du, int dv) {
  if (!edges.connected(p.u, p.v, du, dv)) return std::nullopt;
  const Pixel q{p.u + du, p.v + dv};
  return constraint_between(view, p, q, p, q);
}

// Two-sided where both neighbours are on the surface, one-sided at boundaries; halved when
// two-sided, so that a residual belongs to one sample spacing.
std::optional<Constraint> central_constraint(const RangeView& view, const GridEdges& edges, Pixel p,
                                             int du, int dv, std::uint8_t& sides) {
  const bool before = edges.connected(p.u, p.v, -du, -dv);
  const bool after = edges.connected(p.u, p.v, du, dv);
  sides = static_cast<std::uint8_t>(before + 2 * after);
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

void constrain_row(const RangeView& view, const GridEdges& edges, int v,
                   SlopeConstraints& constraints) {
  for (int u = 0; u < view.width(); ++u) {
    if (!view.has_normal(u, v)) continue;
    const std::size_t i = constraints.grid.index(u, v);
    for (const int direction : {0, 1}) {
      SlopeConstraints::Axis& axis = constraints.axes[static_cast<std::size_t>(direction)];
      const int du = direction == 0, dv = direction == 1;
      const auto found = constraints.stencil == Stencil::kCompactEdge
                             ? compact_constraint(view, edges, {u, v}, du, dv)
                             : central_constraint(view, edges, {u, v}, du, dv, axis.sides[i]);
      if (!found) continue;
      axis.step[i] = found->step;
      axis.tail_slope[i] = found->tail_slope;
      axis.head_slope[i] = found->head_slope;
      axis.half_length[i] = 0.5f * found->length;
      if (constraints.stencil == Stencil::kCompactEdge)
        axis.truncation[i] = static_cast<float>(
            found->length * truncation_of(view, edges, {u, v}, {u + du, v + dv}));
    }
  }
}

}  // namespace

SlopeConstraints::Ends SlopeConstraints::ends(int axis, std::size_t i) const {
  const auto step = static_cast<std::size_t>(grid.step(axis));
  if (stencil == Stencil::kCompactEdge) return {i, i + step, i, i + step};
  const std::uint8_t sides = axes[static_cast<std::size_t>(axis)].sides[i];
  return {sides & 1 ? i - step : i, sides & 2 ? i + step : i, i, i};
}

double SlopeConstraints::truncation_variance(int axis, std::size_t i, double sigma_normal) const {
  const Axis& plane = axes[static_cast<std::size_t>(axis)];
  const double truncation = plane.truncation[i];
  const double noise = 2.0 * plane.half_length[i] * sigma_normal;
  return std::max(0.0, truncation * truncation - 2.0 * kNoiseOfDifferences * noise * noise);
}

void SlopeConstraints::erase(int axis, std::size_t i) {
  Axis& a = axes[static_cast<std::size_t>(axis)];
  a.step[i] = a.tail_slope[i] = a.head_slope[i] = a.half_length[i] = a.truncation[i] = 0.0f;
}

std::size_t SlopeConstraints::count() const {
  std::ptrdiff_t count = 0;
  for (const Axis& axis : axes)
    count += std::count_if(axis.half_length.begin(), axis.half_length.end(),
                           [](float half) { return half > 0.0f; });
  return static_cast<std::size_t>(count);
}

Eigen::Vector3d surface_step(const Ray& tail, const Ray& head, double t,
                             const Eigen::Vector3d& normal) {
  const Eigen::Vector3d across = head.at(t) - tail.at(t);
  const Eigen::Vector3d viewing = tail.direction.normalized() + head.direction.normalized();
  return across - viewing * (normal.dot(across) / normal.dot(viewing));
}

SlopeConstraints slope_constraints(const RangeView& view, const GridEdges& edges, Stencil stencil) {
  SlopeConstraints constraints;
  constraints.stencil = stencil;
  constraints.grid = {view.width(), view.height()};
  const std::size_t size = constraints.grid.size();
  for (SlopeConstraints::Axis& axis : constraints.axes) {
    for (auto* plane :
         {&axis.step, &axis.tail_slope, &axis.head_slope, &axis.half_length, &axis.truncation})
      plane->assign(size, 0.0f);
    if (stencil == Stencil::kPaperCentral) axis.sides.assign(size, 0);
  }
  if (!view.has_normals()) return constraints;
  parallel_for(static_cast<std::size_t>(view.height()), kRowsAtOnce,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t v = begin; v < end; ++v)
                   constrain_row(view, edges, static_cast<int>(v), constraints);
               });
  return constraints;
}

}  // namespace relief::hybrid
