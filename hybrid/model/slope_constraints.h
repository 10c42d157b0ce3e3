#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "hybrid/multigrid/padded_grid.h"
#include "relief/hybrid/refine_view.h"
#include "relief/scan/discontinuities.h"
#include "relief/scan/range_view.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

/// Cosine of incidence below which normals constrain nothing (89 degrees): an error of 0.02 rad
/// (1.1 degrees) turns the sign of a slope there. At half of it 0.6 degrees would.
inline constexpr double kEdgeOnCosine = 0.02;

/// Linear constraints of the measured normals on two samples each, equations (H3) and (H4), at most
/// one per pixel and axis. Samples move along their rays by x = |d| (t - t^m) [unit]; with b the
/// slope error of the normals along the constraint's axis [rad], a constraint asks of
///   step + head_slope x_head - tail_slope x_tail - half_length (b_at0 + b_at1)
/// to vanish. All planes are padded; values are zero where there is no constraint.
struct SlopeConstraints {
  struct Axis {
    std::vector<float> step;                    ///< N . (P_head - P_tail) as measured [unit].
    std::vector<float> tail_slope, head_slope;  ///< N . d / |d| at either end, both negative.
    std::vector<float> half_length;             ///< Of the step on the surface, halved [unit].
    /// Standard deviation of what the compact stencil errs by even with exact normals [unit], from
    /// how the measured ones turn along the line, noise and all; zero for the central one.
    std::vector<float> truncation;
    std::vector<std::uint8_t> sides;  ///< Central: bit 0 reaches back, bit 1 ahead.
  };
  /// Padded indices of the two samples that a constraint moves, and of those whose normals it
  /// averages (equal for one normal).
  struct Ends {
    std::size_t tail = 0, head = 0, at0 = 0, at1 = 0;
  };

  Stencil stencil = Stencil::kCompactEdge;
  PaddedGrid grid;
  std::array<Axis, 2> axes;  ///< Along u, along v.

  bool exists(int axis, std::size_t i) const {
    return axes[static_cast<std::size_t>(axis)].half_length[i] > 0.0f;
  }
  Ends ends(int axis, std::size_t i) const;
  /// Variance of that error [unit^2]: what of `truncation` exceeds twice the noise of the normals,
  /// of standard deviation `sigma_normal` [rad].
  double truncation_variance(int axis, std::size_t i, double sigma_normal) const;
  void erase(int axis, std::size_t i);
  std::size_t count() const;
  bool empty() const { return count() == 0; }

  /// Calls visit(axis, i) for every constraint, axis by axis, row by row.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (int axis = 0; axis < 2; ++axis)
      for (std::size_t i = 0; i < grid.size(); ++i)
        if (exists(axis, i)) visit(axis, i);
  }

  /// The same, axis by axis, but lines along the axis at a time. Constraints along one line share
  /// no sample with those of another, and come in order: visits that write to the ends of their
  /// constraint do not meet, and sums there do not depend on the number of threads.
  template <typename Visit>
  void parallel_for_each(const Visit& visit) const {
    parallel_rows(grid.height, [&](int v) {
      for (std::size_t i = grid.index(0, v); i < grid.index(grid.width, v); ++i)
        if (exists(0, i)) visit(0, i);
    });
    constexpr std::size_t kColumnsAtOnce = 64;  // Of one piece of work; changes no result.
    parallel_for(static_cast<std::size_t>(grid.width), kColumnsAtOnce,
                 [&](std::size_t begin, std::size_t end) {
                   for (int v = 0; v < grid.height; ++v)
                     for (std::size_t u = begin; u < end; ++u)
                       if (const std::size_t i = grid.index(0, v) + u; exists(1, i)) visit(1, i);
                 });
  }
};

/// The tangent of the surface from one ray to a neighbouring one, at range `t` on both: the step
/// between the rays within the plane normal to `normal`. Its length grows without bound as the
/// surface turns edge-on.
Eigen::Vector3d surface_step(const Ray& tail, const Ray& head, double t,
                             const Eigen::Vector3d& normal);

/// The constraints of `view` on `edges`. Only samples with normals that face the sensor take part;
/// no constraint spans an edge that is not connected.
SlopeConstraints slope_constraints(const RangeView& view, const GridEdges& edges, Stencil stencil);

}  // namespace relief::hybrid
