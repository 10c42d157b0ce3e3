#include "registration/posegraph/refinement/block_sandwich.h"

#include <algorithm>
#include <iterator>
#include <set>

#include <Eigen/Dense>

namespace relief::registration {

namespace {

using Indices = std::vector<std::size_t>;  // In ascending order.

// Of a matrix with a unit diagonal. Rounding changes a pivot by some 1e-13, the sum of thousands of
// errors of 1e-16, and one as small as this by a thousandth.
constexpr double kLeastPivot = 1e-10;

// A block and its derivative by e, see sandwich_diagonal().
struct Dual {
  Matrix6d value = Matrix6d::Zero(), by = Matrix6d::Zero();

  Dual transposed() const { return {value.transpose(), by.transpose()}; }
  Dual& operator-=(const Dual& other) {
    value -= other.value;
    by -= other.by;
    return *this;
  }
};

Dual operator*(const Dual& a, const Dual& b) {
  return {a.value * b.value, a.value * b.by + a.by * b.value};
}

// The inverse of a pivot block; nothing where it is not positive definite.
std::optional<Dual> inverse_of(const Dual& a) {
  const Eigen::LLT<Matrix6d> factor(a.value);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const double least = factor.matrixLLT().diagonal().minCoeff();
  if (!(least * least >= kLeastPivot)) return std::nullopt;
  const Matrix6d inverse = factor.solve(Matrix6d::Identity());
  return Dual{inverse, -inverse * a.by * inverse};
}

// The order in which views are eliminated, and for each place in it the later places that its
// column of the factor has blocks at.
struct Elimination {
  Indices place_of;           // By view; that of views left out is not used.
  std::vector<Indices> rows;  // By place.
};

// Least degree first: of several the first view.
Elimination eliminate(std::vector<Indices> neighbours, const std::vector<bool>& left_out) {
  std::set<std::pair<std::size_t, std::size_t>> open;  // Degree and view.
  for (std::size_t i = 0; i < neighbours.size(); ++i)
    if (!left_out[i]) open.emplace(neighbours[i].size(), i);
  Elimination order;
  order.place_of.resize(neighbours.size());
  while (!open.empty()) {
    const std::size_t view = open.begin()->second;
    open.erase(open.begin());
    order.place_of[view] = order.rows.size();
    const Indices clique = std::move(neighbours[view]);
    for (const std::size_t i : clique) {
      open.erase({neighbours[i].size(), i});
      Indices joined;
      std::set_union(neighbours[i].begin(), neighbours[i].end(), clique.begin(), clique.end(),
                     std::back_inserter(joined));
      std::erase_if(joined, [&](std::size_t j) { return j == i || j == view; });
      neighbours[i] = std::move(joined);
      open.emplace(neighbours[i].size(), i);
    }
    order.rows.push_back(clique);
  }
  for (Indices& rows : order.rows) {
    for (std::size_t& row : rows) row = order.place_of[row];
    std::sort(rows.begin(), rows.end());
  }
  return order;
}

std::vector<Indices> neighbours_of(const SymmetricBlocks& a, const SymmetricBlocks& b,
                                   const std::vector<bool>& left_out) {
  std::vector<Indices> neighbours(left_out.size());
  for (const SymmetricBlocks* blocks : {&a, &b}) {
    for (const auto& [at, block] : *blocks) {
      const auto [row, column] = at;
      if (row == column || left_out[row] || left_out[column]) continue;
      neighbours[row].push_back(column);
      neighbours[column].push_back(row);
    }
  }
  for (Indices& of : neighbours) {
    std::sort(of.begin(), of.end());
    of.erase(std::unique(of.begin(), of.end()), of.end());
  }
  return neighbours;
}

// A symmetric matrix on the pattern of the factor, by columns of its lower triangle.
class Columns {
 public:
  explicit Columns(const std::vector<Indices>& rows) : rows_(rows), diagonal_(rows.size()) {
    for (const Indices& of : rows) below_.emplace_back(of.size());
  }

  Dual& diagonal(std::size_t k) { return diagonal_[k]; }
  std::vector<Dual>& below(std::size_t k) { return below_[k]; }

  // The block of row i > j, which is on the pattern.
  Dual& lower(std::size_t i, std::size_t j) {
    const auto place = std::lower_bound(rows_[j].begin(), rows_[j].end(), i);
    return below_[j][static_cast<std::size_t>(place - rows_[j].begin())];
  }

  Dual block(std::size_t i, std::size_t j) {
    if (i == j) return diagonal_[i];
    return i > j ? lower(i, j) : lower(j, i).transposed();
  }

 private:
  const std::vector<Indices>& rows_;
  std::vector<Dual> diagonal_;
  std::vector<std::vector<Dual>> below_;
};

// Factors L of a matrix, whose diagonal becomes the inverse of D, where L D L^T is the matrix.
bool factorise(const std::vector<Indices>& rows, Columns& matrix) {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto inverse = inverse_of(matrix.diagonal(k));
    if (!inverse) return false;
    matrix.diagonal(k) = *inverse;
    const std::vector<Dual> before = matrix.below(k);
    for (Dual& block : matrix.below(k)) block = block * *inverse;
    for (std::size_t j = 0; j < before.size(); ++j) {
      const Dual across = before[j].transposed();
      matrix.diagonal(rows[k][j]) -= matrix.below(k)[j] * across;
      for (std::size_t i = j + 1; i < before.size(); ++i)
        matrix.lower(rows[k][i], rows[k][j]) -= matrix.below(k)[i] * across;
    }
  }
  return true;
}

// The inverse on the pattern of its factors, from the last column to the first.
Columns invert(const std::vector<Indices>& rows, Columns& factors) {
  Columns inverse(rows);
  for (std::size_t k = rows.size(); k-- > 0;) {
    const auto& factor = factors.below(k);
    inverse.diagonal(k) = factors.diagonal(k);
    for (std::size_t i = 0; i < factor.size(); ++i) {
      Dual& block = inverse.below(k)[i];
      for (std::size_t j = 0; j < factor.size(); ++j)
        block -= inverse.block(rows[k][i], rows[k][j]) * factor[j];
      inverse.diagonal(k) -= factor[i].transposed() * block;
    }
  }
  return inverse;
}

}  // namespace

std::optional<std::vector<Matrix6d>> sandwich_diagonal(const SymmetricBlocks& a,
                                                       const SymmetricBlocks& b,
                                                       const std::vector<bool>& left_out) {
  // To a unit diagonal: radians and units differ by orders of magnitude.
  std::vector<Vector6d> scale(left_out.size(), Vector6d::Ones());
  for (const auto& [at, block] : a)
    if (at.first == at.second) scale[at.first] = block.diagonal().cwiseSqrt().cwiseInverse();
  const Elimination order = eliminate(neighbours_of(a, b, left_out), left_out);
  Columns matrix(order.rows);
  const auto fill = [&](const SymmetricBlocks& blocks, double sign, Matrix6d Dual::*part) {
    for (const auto& [at, block] : blocks) {
      const auto [row, column] = at;
      if (left_out[row] || left_out[column]) continue;
      const Matrix6d scaled = sign * (scale[row].asDiagonal() * block * scale[column].asDiagonal());
      const std::size_t i = order.place_of[row], j = order.place_of[column];
      if (i == j)
        matrix.diagonal(i).*part = scaled;
      else if (i > j)
        matrix.lower(i, j).*part = scaled;
      else
        matrix.lower(j, i).*part = scaled.transpose();
    }
  };
  fill(a, 1.0, &Dual::value);
  fill(b, -1.0, &Dual::by);
  if (!factorise(order.rows, matrix)) return std::nullopt;
  Columns inverse = invert(order.rows, matrix);
  std::vector<Matrix6d> result(left_out.size(), Matrix6d::Zero());
  for (std::size_t i = 0; i < left_out.size(); ++i)
    if (!left_out[i])
      result[i] =
          scale[i].asDiagonal() * inverse.diagonal(order.place_of[i]).by * scale[i].asDiagonal();
  return result;
}

}  // namespace relief::registration
