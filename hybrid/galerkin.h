#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "hybrid/aggregation.h"
#include "hybrid/edge_stencil.h"

namespace relief {

/// A sparse matrix of 3 x 3 blocks, row by row.
struct BlockMatrix {
  std::vector<std::uint32_t> begin{0};  ///< Row i is [begin[i], begin[i + 1]).
  std::vector<std::uint32_t> column;
  std::vector<Eigen::Matrix3d> block;

  std::size_t rows() const { return begin.size() - 1; }
};

/// A coarse matrix and the inverses of its diagonal blocks.
struct CoarseMatrix {
  BlockMatrix matrix;
  std::vector<Eigen::Matrix3d> inverse;
};

/// The interpolation of smoothed aggregation is P = (1 - damping D^-1 A) P0 with P0 the rigid
/// motion of the groups; the coarse matrix is P^T A P (Vanek, Mandel and Brezina 1996).
CoarseMatrix coarsen(const EdgeStencil& fine, const Aggregates& groups, double damping,
                     int threads);
/// `fine_rows`: the nodes of row k of the finer level are [fine_rows[k], fine_rows[k + 1]).
CoarseMatrix coarsen(const CoarseMatrix& fine, const std::vector<std::uint32_t>& fine_rows,
                     const Aggregates& groups, double damping, int threads);

}  // namespace relief
