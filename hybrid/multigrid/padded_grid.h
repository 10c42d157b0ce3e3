#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace relief::hybrid {

/// Where the pixels of a grid are in planes that have one column and one row of padding, so that
/// every pixel has four neighbours in memory.
struct PaddedGrid {
  int width = 0, height = 0;

  std::ptrdiff_t stride() const { return width + 1; }
  /// From a pixel to the next along u (axis 0) or v (axis 1).
  std::ptrdiff_t step(int axis) const { return axis == 0 ? 1 : stride(); }
  std::size_t size() const { return static_cast<std::size_t>((height + 2) * stride() + 1); }
  std::uint32_t index(int u, int v) const {
    return static_cast<std::uint32_t>((v + 1) * stride() + u + 1);
  }
  int u(std::size_t i) const {
    return static_cast<int>(i % static_cast<std::size_t>(stride())) - 1;
  }
  int v(std::size_t i) const {
    return static_cast<int>(i / static_cast<std::size_t>(stride())) - 1;
  }
};

/// Pixels [begin, end) of a row, padded indices.
struct RowSpan {
  std::uint32_t begin = 0, end = 0;
};

/// The shortest span of every row that holds all pixels where `inside` (padded) is not zero.
std::vector<RowSpan> row_spans(const PaddedGrid& grid, const std::vector<std::uint8_t>& inside);

}  // namespace relief::hybrid
