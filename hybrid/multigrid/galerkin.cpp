#include "hybrid/multigrid/galerkin.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <Eigen/LU>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kRowsAtOnce = 6;  // rows of groups per independent piece of work

// Rows of blocks, each in no particular order.
struct BlockRows {
  std::vector<std::uint32_t> begin{0};  // row i is [begin[i], begin[i + 1])
  std::vector<std::uint32_t> column;
  std::vector<Eigen::Matrix3d> block;
};

// A row of blocks under construction: few columns, found by search.
class RowSum {
 public:
  void clear() { columns_.clear(), blocks_.clear(); }
  Eigen::Matrix3d& at(std::uint32_t column) {
    for (std::size_t k = 0; k < columns_.size(); ++k)
      if (columns_[k] == column) return blocks_[k];
    columns_.push_back(column);
    return blocks_.emplace_back(Eigen::Matrix3d::Zero());
  }
  std::size_t size() const { return columns_.size(); }
  std::uint32_t column(std::size_t k) const { return columns_[k]; }
  const Eigen::Matrix3d& block(std::size_t k) const { return blocks_[k]; }

  void append_to(BlockRows& rows) const {
    rows.column.insert(rows.column.end(), columns_.begin(), columns_.end());
    rows.block.insert(rows.block.end(), blocks_.begin(), blocks_.end());
    rows.begin.push_back(static_cast<std::uint32_t>(rows.column.size()));
  }
  void append_ordered_to(BlockRows& rows) {
    order_.resize(columns_.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::sort(order_.begin(), order_.end(),
              [&](std::size_t a, std::size_t b) { return columns_[a] < columns_[b]; });
    for (const std::size_t k : order_) {
      rows.column.push_back(columns_[k]);
      rows.block.push_back(blocks_[k]);
    }
    rows.begin.push_back(static_cast<std::uint32_t>(rows.column.size()));
  }

 private:
  std::vector<std::uint32_t> columns_;
  std::vector<Eigen::Matrix3d> blocks_;
  std::vector<std::size_t> order_;
};

// The finest matrix, row by row.
class PixelRows {
 public:
  PixelRows(const EdgeStencil& stencil, const Aggregates& groups)
      : grid_(stencil.grid()), s_(stencil.view()), groups_(groups) {}

  // First pixel of a grid row, padded; rows beyond the grid are empty.
  std::size_t first_of_row(std::ptrdiff_t row) const {
    return grid_.index(0, static_cast<int>(std::clamp<std::ptrdiff_t>(row, 0, grid_.height)));
  }
  bool exists(std::size_t i) const { return groups_.label[i] != kNoAggregate; }
  Eigen::Matrix3d inverse(std::size_t i) const {
    const auto value = [&](int k) { return static_cast<double>(s_.inverse[k][i]); };
    Eigen::Matrix3d inverse;
    inverse << value(0), value(1), value(2), value(1), value(3), value(4), value(2), value(4),
        value(5);
    return inverse;
  }

  template <typename Visit>
  void for_each_block(std::size_t i, const Visit& visit) const {
    Eigen::Matrix3d own = Eigen::Matrix3d::Zero();
    own(0, 0) = s_.mass[i];
    own(1, 1) = own(2, 2) = s_.bias_size;
    const auto stride = static_cast<std::size_t>(s_.stride);
    edge(s_.along_u, 1, i, i, i + 1, own, visit);
    edge(s_.along_u, 1, i - 1, i, i - 1, own, visit);
    edge(s_.along_v, 2, i, i, i + stride, own, visit);
    edge(s_.along_v, 2, i - stride, i, i - stride, own, visit);
    visit(i, own);
  }

 private:
  template <typename Visit>
  void edge(const StencilView::Axis& axis, int bias, std::size_t k, std::size_t i,
            std::size_t other, Eigen::Matrix3d& own, const Visit& visit) const {
    const double weight = axis.weight[k];
    if (weight <= 0.0) return;
    const double half = -double{axis.half_length[k]};
    const double tail = -double{axis.tail[k]}, head = axis.head[k];
    const bool is_tail = k == i;
    const double here = is_tail ? tail : head, there = is_tail ? head : tail;
    const double step = half < 0.0 ? double{s_.bias_step[i]} * s_.bias_step[other] : 0.0;
    own(0, 0) += weight * here * here;
    own(0, bias) += weight * here * half;
    own(bias, 0) += weight * here * half;
    own(bias, bias) += weight * half * half;
    own(1, 1) += step;
    own(2, 2) += step;
    Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
    block(0, 0) = weight * here * there;
    block(0, bias) = weight * here * half;
    block(bias, 0) = weight * half * there;
    block(bias, bias) = weight * half * half;
    block(1, 1) -= step;
    block(2, 2) -= step;
    visit(other, block);
  }

  const PaddedGrid& grid_;
  StencilView s_;
  const Aggregates& groups_;
};

// A coarser matrix, row by row.
class NodeRows {
 public:
  NodeRows(const CoarseMatrix& matrix, const std::vector<std::uint32_t>& rows)
      : m_(matrix), rows_(rows) {}

  std::size_t first_of_row(std::ptrdiff_t row) const {
    const auto last = static_cast<std::ptrdiff_t>(rows_.size()) - 1;
    return rows_[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(row, 0, last))];
  }
  bool exists(std::size_t) const { return true; }
  const Eigen::Matrix3d& inverse(std::size_t i) const { return m_.inverse[i]; }

  template <typename Visit>
  void for_each_block(std::size_t i, const Visit& visit) const {
    m_.matrix.for_each_block(i, visit);
  }

 private:
  const CoarseMatrix& m_;
  const std::vector<std::uint32_t>& rows_;
};

// The coarse rows of groups in some rows of blocks. Interpolation reaches one row of nodes beyond a
// group, its product with A two.
template <typename Rows>
class Piece {
 public:
  Piece(const Rows& rows, const Aggregates& groups, double damping)
      : rows_(rows), groups_(groups), damping_(damping) {}

  // Blocks on and above the diagonal.
  BlockRows coarse_rows(std::size_t first_row, std::size_t end_row) {
    const auto low = static_cast<std::ptrdiff_t>(3 * first_row);
    const auto high = static_cast<std::ptrdiff_t>(3 * end_row);
    interpolate(rows_.first_of_row(low - 2), rows_.first_of_row(high + 2));
    const std::size_t begin = rows_.first_of_row(low - 1), end = rows_.first_of_row(high + 1);
    multiply(begin, end);
    return project(begin, end, groups_.rows[first_row], groups_.rows[end_row]);
  }

 private:
  // P for nodes [begin, end).
  void interpolate(std::size_t begin, std::size_t end) {
    p_begin_ = begin;
    RowSum sum;
    for (std::size_t i = begin; i < end; ++i) {
      sum.clear();
      if (rows_.exists(i)) interpolate_node(i, sum);
      sum.append_to(p_);
    }
  }

  void interpolate_node(std::size_t i, RowSum& sum) {
    rows_.for_each_block(i, [&](std::size_t j, const auto& a) {
      const std::uint32_t group = groups_.label[j];
      if (group == kNoAggregate) return;
      // A times the rigid motion [scale along_u along_v; 0 1 0; 0 0 1] of the group's member.
      const Transport& motion = groups_.from_root[j];
      Eigen::Matrix3d& target = sum.at(group);
      target.col(0) += a.col(0) * motion.scale;
      target.col(1) += a.col(0) * motion.along_u + a.col(1);
      target.col(2) += a.col(0) * motion.along_v + a.col(2);
    });
    const Eigen::Matrix3d scaled = -damping_ * rows_.inverse(i);
    smoothed_.clear();
    for (std::size_t k = 0; k < sum.size(); ++k)
      smoothed_.at(sum.column(k)).noalias() = scaled * sum.block(k);
    if (const std::uint32_t own = groups_.label[i]; own != kNoAggregate) {
      const Transport& motion = groups_.from_root[i];
      Eigen::Matrix3d& target = smoothed_.at(own);
      target.row(0) += Eigen::RowVector3d(motion.scale, motion.along_u, motion.along_v);
      target(1, 1) += 1.0;
      target(2, 2) += 1.0;
    }
    std::swap(sum, smoothed_);
  }

  // A P for nodes [begin, end).
  void multiply(std::size_t begin, std::size_t end) {
    RowSum sum;
    for (std::size_t i = begin; i < end; ++i) {
      sum.clear();
      if (rows_.exists(i) && p_.begin[i - p_begin_] != p_.begin[i - p_begin_ + 1]) {
        rows_.for_each_block(i, [&](std::size_t j, const auto& a) {
          for (std::uint32_t k = p_.begin[j - p_begin_]; k < p_.begin[j - p_begin_ + 1]; ++k)
            sum.at(p_.column[k]).noalias() += a * p_.block[k];
        });
      }
      sum.append_to(ap_);
    }
  }

  // P^T (A P) for groups [first, last); nodes [begin, end) are all that interpolate from them.
  BlockRows project(std::size_t begin, std::size_t end, std::uint32_t first, std::uint32_t last) {
    std::vector<std::uint32_t> offset(last - first + 2, 0);
    const auto for_each_entry = [&](const auto& visit) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::uint32_t k = p_.begin[i - p_begin_]; k < p_.begin[i - p_begin_ + 1]; ++k)
          if (p_.column[k] >= first && p_.column[k] < last) visit(i, k, p_.column[k] - first);
    };
    for_each_entry([&](std::size_t, std::uint32_t, std::uint32_t row) { ++offset[row + 2]; });
    for (std::size_t row = 2; row < offset.size(); ++row) offset[row] += offset[row - 1];
    struct Entry {
      std::uint32_t node, place;
    };
    std::vector<Entry> entries(offset.back());
    for_each_entry([&](std::size_t i, std::uint32_t k, std::uint32_t row) {
      entries[offset[row + 1]++] = {static_cast<std::uint32_t>(i - begin), k};
    });
    BlockRows rows;
    RowSum sum;
    for (std::uint32_t row = 0; row < last - first; ++row) {
      sum.clear();
      for (std::uint32_t e = offset[row]; e < offset[row + 1]; ++e) {
        const Eigen::Matrix3d transposed = p_.block[entries[e].place].transpose();
        const std::uint32_t node = entries[e].node;
        for (std::uint32_t k = ap_.begin[node]; k < ap_.begin[node + 1]; ++k)
          if (ap_.column[k] >= first + row)
            sum.at(ap_.column[k]).noalias() += transposed * ap_.block[k];
      }
      sum.append_ordered_to(rows);
    }
    return rows;
  }

  const Rows& rows_;
  const Aggregates& groups_;
  double damping_;
  RowSum smoothed_;
  std::size_t p_begin_ = 0;
  BlockRows p_, ap_;
};

void append(BlockRows&& piece, BlockRows& rows) {
  const auto before = static_cast<std::uint32_t>(rows.column.size());
  for (std::size_t i = 1; i < piece.begin.size(); ++i)
    rows.begin.push_back(before + piece.begin[i]);
  rows.column.insert(rows.column.end(), piece.column.begin(), piece.column.end());
  rows.block.insert(rows.block.end(), piece.block.begin(), piece.block.end());
  piece = {};
}

std::vector<Eigen::Matrix3d> inverse_diagonal(const BlockRows& upper) {
  std::vector<Eigen::Matrix3d> inverse;
  for (std::size_t i = 0; i + 1 < upper.begin.size(); ++i)
    inverse.push_back(upper.block[upper.begin[i]].inverse());
  return inverse;
}

template <typename Rows>
CoarseMatrix coarsen_rows(const Rows& fine, const Aggregates& groups, double damping) {
  const std::size_t count = groups.rows.size() - 1;
  std::vector<BlockRows> pieces((count + kRowsAtOnce - 1) / kRowsAtOnce);
  parallel_for(count, kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
    pieces[begin / kRowsAtOnce] = Piece<Rows>(fine, groups, damping).coarse_rows(begin, end);
  });
  BlockRows upper;
  std::size_t blocks = 0;
  for (const BlockRows& piece : pieces) blocks += piece.block.size();
  upper.column.reserve(blocks);
  upper.block.reserve(blocks);
  for (BlockRows& piece : pieces) append(std::move(piece), upper);
  CoarseMatrix coarse;
  coarse.inverse = inverse_diagonal(upper);
  coarse.matrix = BlockMatrix(upper.begin, upper.column, std::move(upper.block));
  return coarse;
}

}  // namespace

BlockMatrix::BlockMatrix(const std::vector<std::uint32_t>& upper_begin,
                         const std::vector<std::uint32_t>& upper_column,
                         std::vector<Eigen::Matrix3d> block)
    : begin_(upper_begin.size(), 0), block_(std::move(block)) {
  const std::size_t count = upper_begin.size() - 1;
  const auto for_each_upper = [&](const auto& visit) {
    for (std::uint32_t i = 0; i < count; ++i)
      for (std::uint32_t k = upper_begin[i]; k < upper_begin[i + 1]; ++k)
        visit(i, upper_column[k], k);
  };
  for_each_upper([&](std::uint32_t i, std::uint32_t column, std::uint32_t) {
    ++begin_[i + 1];
    if (column != i) ++begin_[column + 1];
  });
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  entry_.resize(begin_.back());
  // Rows come in order, so that the mirror images of earlier rows precede a row's own entries.
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for_each_upper([&](std::uint32_t i, std::uint32_t column, std::uint32_t k) {
    entry_[next[i]++] = {column, k};
    if (column != i) entry_[next[column]++] = {i, k};
  });
}

CoarseMatrix coarsen(const EdgeStencil& fine, const Aggregates& groups, double damping) {
  return coarsen_rows(PixelRows(fine, groups), groups, damping);
}

CoarseMatrix coarsen(const CoarseMatrix& fine, const std::vector<std::uint32_t>& fine_rows,
                     const Aggregates& groups, double damping) {
  return coarsen_rows(NodeRows(fine, fine_rows), groups, damping);
}

}  // namespace relief::hybrid
