#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "relief/scan/grid.h"
#include "scan/base/memory/paged_array.h"

namespace relief::fusion {

/// Greatest depths over rectangles of pixels, coarser by two from level to level, so that a
/// rectangle of any size is answered by looking at a few cells.
class DepthPyramid {
 public:
  DepthPyramid() = default;
  /// Depths of the pixels; -infinity where there is nothing. `memory` may be null.
  explicit DepthPyramid(const Grid<float>& depths, MemoryLimit* memory = nullptr);

  /// A depth that none of the pixels in the rectangle (ends included, cropped to the grid) exceeds,
  /// and that some pixel in it or close by has; -infinity where there is nothing.
  float greatest(const Eigen::AlignedBox2i& pixels) const;

  /// The depth of a pixel.
  float at(int u, int v) const { return levels_.front()(u, v); }

 private:
  std::vector<PagedGrid<float>> levels_;
};

}  // namespace relief::fusion
