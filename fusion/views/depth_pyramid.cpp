#include "fusion/views/depth_pyramid.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

namespace relief::fusion {

namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();

PagedGrid<float> halved(const PagedGrid<float>& fine, MemoryLimit* memory) {
  PagedGrid<float> coarse((fine.width() + 1) / 2, (fine.height() + 1) / 2, memory);
  std::fill(coarse.begin(), coarse.end(), kNothing);
  for (int v = 0; v < fine.height(); ++v)
    for (int u = 0; u < fine.width(); ++u)
      coarse(u / 2, v / 2) = std::max(coarse(u / 2, v / 2), fine(u, v));
  return coarse;
}

}  // namespace

DepthPyramid::DepthPyramid(const Grid<float>& depths, MemoryLimit* memory) {
  levels_.emplace_back(depths.width(), depths.height(), memory);
  std::copy(depths.begin(), depths.end(), levels_.back().begin());
  while (levels_.back().width() > 1 || levels_.back().height() > 1) {
    // Small levels are not worth a file.
    const bool large = levels_.back().width() > 256 || levels_.back().height() > 256;
    levels_.push_back(halved(levels_.back(), large ? memory : nullptr));
  }
}

float DepthPyramid::greatest(const Eigen::AlignedBox2i& pixels) const {
  if (levels_.empty()) return kNothing;
  const PagedGrid<float>& all = levels_.front();
  Eigen::AlignedBox2i box(
      pixels.min().cwiseMax(0),
      pixels.max().cwiseMin(Eigen::Vector2i(all.width(), all.height()) - Eigen::Vector2i::Ones()));
  if (box.isEmpty()) return kNothing;
  std::size_t level = 0;
  for (; box.sizes().maxCoeff() > 2; ++level) {
    box.min() /= 2;
    box.max() /= 2;
  }
  float greatest = kNothing;
  for (int v = box.min().y(); v <= box.max().y(); ++v)
    for (int u = box.min().x(); u <= box.max().x(); ++u)
      greatest = std::max(greatest, levels_[level](u, v));
  return greatest;
}

}  // namespace relief::fusion
