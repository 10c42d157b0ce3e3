#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "hybrid/multigrid/aggregation.h"
#include "hybrid/multigrid/edge_stencil.h"

namespace relief::hybrid {

/// A symmetric sparse matrix of 3 x 3 blocks. Only blocks on and above the diagonal are stored; a
/// row lists all of its blocks, in order of column.
class BlockMatrix {
 public:
  BlockMatrix() = default;
  /// `upper_begin`: entries of row i, on and above the diagonal, are [upper_begin[i],
  /// upper_begin[i + 1]) of `upper_column` and `block`, in order of column.
  BlockMatrix(const std::vector<std::uint32_t>& upper_begin,
              const std::vector<std::uint32_t>& upper_column, std::vector<Eigen::Matrix3d> block);

  std::size_t rows() const { return begin_.size() - 1; }

  /// Calls visit(column, block) for every block of a row.
  template <typename Visit>
  void for_each_block(std::size_t row, const Visit& visit) const {
    std::uint32_t k = begin_[row];
    for (; entry_[k].column < row; ++k)
      visit(entry_[k].column, block_[entry_[k].place].transpose());
    for (; k < begin_[row + 1]; ++k) visit(entry_[k].column, block_[entry_[k].place]);
  }

 private:
  struct Entry {
    std::uint32_t column, place;
  };
  std::vector<std::uint32_t> begin_{0};
  std::vector<Entry> entry_;
  std::vector<Eigen::Matrix3d> block_;
};

/// A coarse matrix and the inverses of its diagonal blocks.
struct CoarseMatrix {
  BlockMatrix matrix;
  std::vector<Eigen::Matrix3d> inverse;
};

/// The interpolation of smoothed aggregation is P = (1 - damping D^-1 A) P0 with P0 the rigid
/// motion of the groups; the coarse matrix is P^T A P (Vanek, Mandel and Brezina 1996).
CoarseMatrix coarsen(const EdgeStencil& fine, const Aggregates& groups, double damping);
/// `fine_rows`: the nodes of row k of the finer level are [fine_rows[k], fine_rows[k + 1]).
CoarseMatrix coarsen(const CoarseMatrix& fine, const std::vector<std::uint32_t>& fine_rows,
                     const Aggregates& groups, double damping);

}  // namespace relief::hybrid
