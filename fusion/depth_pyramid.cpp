#include "fusion/depth_pyramid.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

namespace relief {

namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();

Grid<float> halved(const Grid<float>& fine) {
  Grid<float> coarse((fine.width() + 1) / 2, (fine.height() + 1) / 2, kNothing);
  for (int v = 0; v < fine.height(); ++v)
    for (int u = 0; u < fine.width(); ++u)
      coarse(u / 2, v / 2) = std::max(coarse(u / 2, v / 2), fine(u, v));
  return coarse;
}

}  // namespace

DepthPyramid::DepthPyramid(Grid<float> depths) {
  levels_.push_back(std::move(depths));
  while (levels_.back().width() > 1 || levels_.back().height() > 1)
    levels_.push_back(halved(levels_.back()));
}

float DepthPyramid::greatest(const Eigen::AlignedBox2i& pixels) const {
  if (levels_.empty()) return kNothing;
  const Grid<float>& all = levels_.front();
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

}  // namespace relief
