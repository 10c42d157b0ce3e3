#include "hybrid/multigrid/padded_grid.h"

namespace relief::hybrid {

std::vector<RowSpan> row_spans(const PaddedGrid& grid, const std::vector<std::uint8_t>& inside) {
  std::vector<RowSpan> spans;
  for (int v = 0; v < grid.height; ++v) {
    RowSpan span{grid.index(0, v), grid.index(0, v)};
    for (std::uint32_t i = grid.index(0, v); i < grid.index(grid.width, v); ++i) {
      if (!inside[i]) continue;
      if (span.begin == span.end) span.begin = i;
      span.end = i + 1;
    }
    spans.push_back(span);
  }
  return spans;
}

}  // namespace relief::hybrid
