#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hybrid/edge_stencil_kernels.h"

namespace relief {

/// Where the pixels of a grid are in planes that have one column and one row of padding, so that
/// every pixel has four neighbours in memory.
struct PaddedGrid {
  int width = 0, height = 0;

  std::ptrdiff_t stride() const { return width + 1; }
  std::size_t size() const { return static_cast<std::size_t>((height + 2) * stride() + 1); }
  std::uint32_t index(int u, int v) const {
    return static_cast<std::uint32_t>((v + 1) * stride() + u + 1);
  }
};

/// Values of the three unknowns x, b_u, b_v of every pixel; zero on padding.
template <typename T>
struct Planes {
  Planes() = default;
  explicit Planes(std::size_t size) : x(size, T(0)), bu(size, T(0)), bv(size, T(0)) {}
  std::vector<T> x, bu, bv;

  PlanesView<T> view() { return {x.data(), bu.data(), bv.data()}; }
  PlanesView<const T> view() const { return {x.data(), bu.data(), bv.data()}; }
};

/// The normal equations of (7a) with the compact stencil (6) on the grid of a view, by coefficients
/// rather than as a matrix. The constraint of pixel (u,v) along u spans the edge to (u+1,v), along
/// v that to (u,v+1); its residual is
///   step + head x_head - tail x_tail - half_length (b_tail + b_head).
/// Coefficients are zero where there is no constraint. Planes are padded.
class EdgeStencil {
 public:
  struct Axis {
    std::vector<float> tail, head, half_length;
    std::vector<float> weight;
  };

  EdgeStencil() = default;
  explicit EdgeStencil(PaddedGrid grid);

  PaddedGrid grid;
  std::vector<float> mass;  ///< Weight of the position of every pixel; zero where none moves.
  Axis along_u, along_v;
  float bias_step = 0.0f;  ///< Weight of the change of the bias along every constraint.
  float bias_size = 1.0f;  ///< Weight of the bias itself.

  /// Columns [begin, end) of every row outside of which no pixel moves. Set by find_spans().
  struct Span {
    std::uint32_t begin = 0, end = 0;  ///< Padded indices.
  };
  std::vector<Span> spans;

  /// To be called when it is known which pixels move: those with `movable` (padded) non-zero.
  void find_spans(const std::vector<std::uint8_t>& movable);
  /// To be called after every change of weights: inverts the diagonal blocks.
  void invert_blocks(int threads);
  StencilView view() const;

 private:
  std::vector<float> inverse_[6];
};

}  // namespace relief
