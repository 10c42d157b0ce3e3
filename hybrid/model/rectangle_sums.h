#pragma once

#include <algorithm>
#include <cstddef>

#include "hybrid/multigrid/padded_grid.h"
#include "relief/scan/grid.h"
#include "scan/base/parallel.h"

namespace relief::hybrid {

/// Sums over rectangles of a grid in constant time.
class RectangleSums {
 public:
  /// Of `value` at the padded index of each pixel.
  template <typename Value>
  RectangleSums(const PaddedGrid& grid, const Value& value)
      : sums_(grid.width + 1, grid.height + 1, 0.0) {
    parallel_rows(grid.height, [&](int v) {
      for (int u = 0; u < grid.width; ++u)
        sums_(u + 1, v + 1) = sums_(u, v + 1) + value(grid.index(u, v));
    });
    constexpr std::size_t kColumnsAtOnce = 64;  // Of one piece of work; changes no result.
    parallel_for(static_cast<std::size_t>(sums_.width()), kColumnsAtOnce,
                 [&](std::size_t begin, std::size_t end) {
                   for (int v = 1; v < sums_.height(); ++v)
                     for (int u = static_cast<int>(begin); u < static_cast<int>(end); ++u)
                       sums_(u, v) += sums_(u, v - 1);
                 });
  }

  /// Of columns [u0, u1) and rows [v0, v1), as far as they are on the grid.
  double operator()(int u0, int u1, int v0, int v1) const {
    const auto column = [&](int u) { return std::clamp(u, 0, sums_.width() - 1); };
    const auto row = [&](int v) { return std::clamp(v, 0, sums_.height() - 1); };
    return sums_(column(u1), row(v1)) - sums_(column(u0), row(v1)) - sums_(column(u1), row(v0)) +
           sums_(column(u0), row(v0));
  }

 private:
  Grid<double> sums_;
};

}  // namespace relief::hybrid
