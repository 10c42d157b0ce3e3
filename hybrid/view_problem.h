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
  Stencil stencil = Stencil::kCompactEdge;
  int width = 0, height = 0;          ///< Of the grid.
  std::vector<std::uint32_t> pixels;  ///< Grid index of every movable sample, ascending.
  Eigen::VectorXd confidence;         ///< Of every movable sample; each component has some > 0.
  std::vector<SlopeConstraint> slopes;
  /// Neighbours on the surface, both with normals: where the bias is smooth.
  std::vector<std::array<std::uint32_t, 2>> neighbours;
  std::size_t pinned = 0;  ///< Samples that keep their measured range.

  std::size_t size() const { return pixels.size(); }
  bool empty() const { return slopes.empty(); }
};

/// The weights of the terms of equation (7a), each the inverse of a variance.
struct ViewWeights {
  Eigen::VectorXf position;  ///< Per movable sample [1/unit^2].
  Eigen::VectorXf slope;     ///< Per slope constraint [1/unit^2].
  float bias_step = 0.0f;    ///< Of the change of the bias between neighbours [1/rad^2].
  float bias_size = 0.0f;    ///< Of the bias itself [1/rad^2]; keeps islands determined.
};

/// Movable are the samples that a normal constrains and whose connected component holds at least
/// one sample of positive confidence; all others keep their measured range and constrain nothing.
ViewProblem make_view_problem(const RangeView& view, const GridEdges& edges, Stencil stencil);

/// Residual of every slope constraint [unit] at y = [x; b_u; b_v], or at y = x without a bias.
Eigen::VectorXd slope_residuals(const ViewProblem& problem, const Eigen::VectorXd& y);

}  // namespace relief
