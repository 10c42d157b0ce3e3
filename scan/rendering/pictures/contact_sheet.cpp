#include <algorithm>
#include <cassert>
#include <numeric>

#include "relief/rendering/picture.h"

namespace relief::rendering {

namespace {

constexpr int kGap = 8;  // Between pictures [pixels].

// Where each strip of `sizes` begins, and last where all end.
std::vector<int> places(const std::vector<int>& sizes) {
  std::vector<int> places{0};
  for (const int size : sizes) places.push_back(places.back() + size + kGap);
  places.back() -= kGap;
  return places;
}

}  // namespace

Picture contact_sheet(const std::vector<Picture>& pictures, int columns, Background background) {
  assert(columns >= 1);
  if (pictures.empty()) return {};
  const auto across = std::min(static_cast<std::size_t>(columns), pictures.size());
  std::vector<int> widths(across, 0), heights((pictures.size() + across - 1) / across, 0);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    widths[i % across] = std::max(widths[i % across], pictures[i].width());
    heights[i / across] = std::max(heights[i / across], pictures[i].height());
  }
  const std::vector<int> lefts = places(widths), tops = places(heights);
  Picture sheet(lefts.back(), tops.back(), background_colour(background));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const Picture& picture = pictures[i];
    // In the middle of its column, at the top of its row: captions line up.
    const int left = lefts[i % across] + (widths[i % across] - picture.width()) / 2;
    const int top = tops[i / across];
    for (int v = 0; v < picture.height(); ++v)
      for (int u = 0; u < picture.width(); ++u) sheet(left + u, top + v) = picture(u, v);
  }
  return sheet;
}

}  // namespace relief::rendering
