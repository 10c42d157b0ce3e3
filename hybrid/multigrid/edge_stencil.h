#pragma once

#include <cstddef>
#include <vector>

#include "hybrid/model/view_problem.h"
#include "hybrid/multigrid/edge_stencil_kernels.h"
#include "hybrid/multigrid/padded_grid.h"

namespace relief::hybrid {

/// Values of the three unknowns x, b_u, b_v of every pixel; zero where none moves.
template <typename T>
struct Planes {
  Planes() = default;
  explicit Planes(std::size_t size) : x(size, T(0)), bu(size, T(0)), bv(size, T(0)) {}
  std::vector<T> x, bu, bv;

  PlanesView<T> view() { return {x.data(), bu.data(), bv.data()}; }
  PlanesView<const T> view() const { return {x.data(), bu.data(), bv.data()}; }
};

/// The matrix A of the normal equations of (H5) with the compact stencil (H4), by its coefficients:
/// never stored as a matrix. Without a bias, its unknowns stay zero.
class EdgeStencil {
 public:
  /// `problem` must have the compact stencil and outlive the object.
  EdgeStencil(const ViewProblem& problem, bool with_bias);

  /// Puts in weights and inverts the diagonal blocks.
  void set_weights(ViewWeights weights);

  const PaddedGrid& grid() const { return problem_.grid; }
  /// The spans of all rows that hold the movable samples.
  const std::vector<RowSpan>& spans() const { return spans_; }
  StencilView view() const;

 private:
  const ViewProblem& problem_;
  std::vector<RowSpan> spans_;
  std::vector<float> no_length_;  // in place of the lengths when there is no bias
  ViewWeights weights_;
  std::vector<float> inverse_[6];
};

}  // namespace relief::hybrid
