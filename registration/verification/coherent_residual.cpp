#include "registration/verification/coherent_residual.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>

namespace relief::registration {

namespace {

// A cell of a lattice. Those of a column (x, y) follow each other in lexicographic order.
using Cell = std::array<int, 3>;

// Points sorted by cells of a lattice, with their residuals. FLANN's radius search takes more than
// four times as long.
class SortedPoints {
 public:
  SortedPoints(const Eigen::Matrix3Xd& points, const std::vector<double>& residuals, double side) {
    std::vector<std::pair<Cell, Eigen::Index>> order;
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const Eigen::Array3d index = ((points.col(i) - points.col(0)) / side).array().floor();
      order.push_back(
          {{static_cast<int>(index.x()), static_cast<int>(index.y()), static_cast<int>(index.z())},
           i});
    }
    std::ranges::sort(order);
    for (const auto& [cell, i] : order) {
      cells_.push_back(cell);
      points_.push_back(points.col(i));
      residuals_.push_back(residuals[static_cast<std::size_t>(i)]);
    }
  }

  std::size_t size() const { return points_.size(); }
  const Cell& cell(std::size_t i) const { return cells_[i]; }

  // Sums over the points of a range whose distance to a point lies in a band.
  struct Sum {
    double residuals = 0.0, points = 0.0;
  };
  Sum sum_near(std::size_t i, std::size_t begin, std::size_t end, const DistanceBand& band) const {
    const double nearest = band.nearest * band.nearest, farthest = band.farthest * band.farthest;
    const Eigen::Vector3d point = points_[i];
    Sum sum;
    for (std::size_t j = begin; j < end; ++j) {
      const double squared = (points_[j] - point).squaredNorm();
      // Not a condition, which processors guess wrong for a third of the points.
      const double counts = static_cast<double>((squared >= nearest) & (squared <= farthest));
      sum.residuals += counts * residuals_[j];
      sum.points += counts;
    }
    return sum;
  }
  double residual(std::size_t i) const { return residuals_[i]; }

 private:
  std::vector<Cell> cells_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<double> residuals_;
};

// Where the points of a cell begin, or those after it, for cells in ascending order.
class BeginOfCell {
 public:
  std::size_t operator()(const SortedPoints& sorted, const Cell& cell) {
    while (place_ < sorted.size() && sorted.cell(place_) < cell) ++place_;
    return place_;
  }

 private:
  std::size_t place_ = 0;
};

}  // namespace

double coherent_rms(const Eigen::Matrix3Xd& points, const std::vector<double>& residuals,
                    const DistanceBand& band) {
  assert(static_cast<std::size_t>(points.cols()) == residuals.size());
  assert(band.nearest >= 0.0 && band.farthest > band.nearest);
  double products = 0.0, pairs = 0.0;
  const SortedPoints sorted(points, residuals, band.farthest);
  // The columns of cells that follow a cell: with the later points of the cell itself and those
  // above it, each pair of neighbours once.
  constexpr std::array<std::pair<int, int>, 4> kColumns{{{0, 1}, {1, -1}, {1, 0}, {1, 1}}};
  BeginOfCell next, above;
  std::array<BeginOfCell, kColumns.size()> below_in, above_in;
  for (std::size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
    const auto [x, y, z] = sorted.cell(begin);
    end = next(sorted, {x, y, z + 1});
    const std::size_t end_above = above(sorted, {x, y, z + 2});
    std::array<std::pair<std::size_t, std::size_t>, kColumns.size()> columns;
    for (std::size_t k = 0; k < kColumns.size(); ++k) {
      const int x_there = x + kColumns[k].first, y_there = y + kColumns[k].second;
      columns[k] = {below_in[k](sorted, {x_there, y_there, z - 1}),
                    above_in[k](sorted, {x_there, y_there, z + 2})};
    }
    for (std::size_t i = begin; i < end; ++i) {
      const auto add = [&](std::size_t first, std::size_t last) {
        const auto sum = sorted.sum_near(i, first, last, band);
        products += sorted.residual(i) * sum.residuals;
        pairs += sum.points;
      };
      add(i + 1, end_above);
      for (const auto& [first, last] : columns) add(first, last);
    }
  }
  return pairs > 0.0 ? std::sqrt(std::max(0.0, products / pairs)) : 0.0;
}

}  // namespace relief::registration
