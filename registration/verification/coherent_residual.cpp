#include "registration/verification/coherent_residual.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>

namespace relief::registration {

namespace {

using Cell = std::array<long, 3>;
using Cells = std::map<Cell, std::vector<Eigen::Index>>;

// FLANN's radius search takes four times as long: 6.8 ms for 1500 points, instead of 1.8 ms.
Cells sort_into_cells(const Eigen::Matrix3Xd& points, double side) {
  Cells cells;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d index = ((points.col(i) - points.col(0)) / side).array().floor();
    cells[{static_cast<long>(index.x()), static_cast<long>(index.y()),
           static_cast<long>(index.z())}]
        .push_back(i);
  }
  return cells;
}

// The 13 neighbours of a cell that follow it in lexicographic order: each pair of cells once.
const std::vector<Cell>& following_neighbours() {
  static const auto neighbours = [] {
    std::vector<Cell> list;
    for (long x = -1; x <= 1; ++x)
      for (long y = -1; y <= 1; ++y)
        for (long z = -1; z <= 1; ++z)
          if (Cell{x, y, z} > Cell{0, 0, 0}) list.push_back({x, y, z});
    return list;
  }();
  return neighbours;
}

}  // namespace

double coherent_rms(const Eigen::Matrix3Xd& points, const std::vector<double>& residuals,
                    const DistanceBand& band) {
  assert(static_cast<std::size_t>(points.cols()) == residuals.size());
  assert(band.nearest >= 0.0 && band.farthest > band.nearest);
  if (residuals.empty()) return 0.0;
  double products = 0.0, pairs = 0.0;
  const auto add = [&](Eigen::Index i, Eigen::Index j) {
    const double squared = (points.col(i) - points.col(j)).squaredNorm();
    if (squared < band.nearest * band.nearest || squared > band.farthest * band.farthest) return;
    products += residuals[static_cast<std::size_t>(i)] * residuals[static_cast<std::size_t>(j)];
    ++pairs;
  };
  const Cells cells = sort_into_cells(points, band.farthest);
  for (const auto& [cell, members] : cells) {
    for (std::size_t k = 0; k < members.size(); ++k)
      for (std::size_t l = k + 1; l < members.size(); ++l) add(members[k], members[l]);
    for (const Cell& step : following_neighbours()) {
      const auto other = cells.find({cell[0] + step[0], cell[1] + step[1], cell[2] + step[2]});
      if (other == cells.end()) continue;
      for (const Eigen::Index i : members)
        for (const Eigen::Index j : other->second) add(i, j);
    }
  }
  return pairs > 0.0 ? std::sqrt(std::max(0.0, products / pairs)) : 0.0;
}

}  // namespace relief::registration
