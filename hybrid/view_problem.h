#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "hybrid/slope_constraints.h"
#include "scan/range_view.h"

namespace relief {

/// What refining a view minimises, before weights: the samples that can move and the constraints
/// between them. Sample indices of `slopes` and `neighbours` count the movable samples only.
struct ViewProblem {
  std::vector<std::uint32_t> pixels;  ///< Grid index of every movable sample, ascending.
  Eigen::VectorXd confidence;         ///< Of every movable sample; each component has some > 0.
  std::vector<SlopeConstraint> slopes;
  /// Neighbours on the surface, both with normals: where the bias is smooth.
  std::vector<std::array<std::uint32_t, 2>> neighbours;
  std::size_t pinned = 0;  ///< Samples that keep their measured range.

  std::size_t size() const { return pixels.size(); }
  bool empty() const { return slopes.empty(); }
};

/// Movable are the samples that a normal constrains and whose connected component holds at least
/// one sample of positive confidence; all others keep their measured range and constrain nothing.
ViewProblem make_view_problem(const RangeView& view, const GridEdges& edges, Stencil stencil);

}  // namespace relief
