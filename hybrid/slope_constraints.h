#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "scan/discontinuities.h"
#include "scan/grid.h"
#include "scan/range_view.h"

namespace relief {

/// How a normal constrains the ranges next to it.
enum class Stencil {
  kCompactEdge,   ///< Equation (6): one constraint per grid edge, with the normals of both ends.
  kPaperCentral,  ///< Equation (4): central differences at each sample (Nehab et al. 2005).
};

/// One linear constraint of the measured normals on two samples, equations (4) to (6). Samples move
/// along their rays by x = |d| (t - t^m) [unit]; with b the slope error of the normals along the
/// constraint's tangent [rad], the constraint asks of
///   step + head_slope x_head - tail_slope x_tail - length (b_at0 + b_at1) / 2
/// to vanish. Indices are those of the grid, row by row.
struct SlopeConstraint {
  std::uint32_t tail = 0, head = 0;            ///< The two samples that it moves.
  std::array<std::uint32_t, 2> at{};           ///< Whose normals it averages; equal for one normal.
  int axis = 0;                                ///< 0: along rows (u), 1: along columns (v).
  float step = 0.0f;                           ///< N . (P_head - P_tail) as measured [unit].
  float tail_slope = 0.0f, head_slope = 0.0f;  ///< N . d / |d| at either end, both negative.
  float length = 0.0f;                         ///< Of the step on the surface [unit].
};

/// The tangent of the surface from one ray to a neighbouring one, at range `t` on both: the step
/// between the rays within the plane normal to `normal`. Its length grows without bound as the
/// surface turns edge-on.
Eigen::Vector3d surface_step(const Ray& tail, const Ray& head, double t,
                             const Eigen::Vector3d& normal);

/// The constraints of `view` on `edges`, ordered by pixel and axis. Only samples with normals that
/// face the sensor take part; no constraint spans an edge that is not connected.
std::vector<SlopeConstraint> slope_constraints(const RangeView& view, const GridEdges& edges,
                                               Stencil stencil);

}  // namespace relief
