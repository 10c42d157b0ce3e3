#include "scan/background/fixed_surface.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "scan/base/disjoint_sets.h"
#include "scan/base/parallel.h"

namespace relief {

namespace {

constexpr std::size_t kFewestViews = 3;   // that measure the same depth
constexpr double kSmallestPiece = 0.002;  // fraction of the image's pixels
const float kNoDepth = static_cast<float>(kNoSample);

// The depths of all views at a pixel, the farthest first.
void depths_at(const DepthStack& stack, int u, int v, std::vector<float>& depths) {
  depths.clear();
  for (const Grid<float>& view : stack.depths)
    if (const float depth = view(u, v); depth == depth) depths.push_back(depth);
  std::sort(depths.begin(), depths.end(), std::greater<>());
}

// The farthest depth on which a quarter of the views agree that see anything here, which must be
// half of all. A tenth of them may be wild and farther.
float fixed_depth(const std::vector<float>& depths, float tolerance, std::size_t views) {
  if (2 * depths.size() < views) return kNoDepth;
  const std::size_t needed = std::max(kFewestViews, (depths.size() + 3) / 4);
  for (std::size_t first = 0; first <= depths.size() / 10; ++first) {
    std::size_t end = first;
    while (end < depths.size() && depths[first] - depths[end] <= 2.0f * tolerance) ++end;
    if (end - first >= needed) return depths[first + (end - first) / 2];
  }
  return kNoDepth;
}

RangeView as_view(const DepthStack& stack, const Grid<float>& depth) {
  RangeView view;
  view.camera = stack.camera;
  view.range = Grid<double>(depth.width(), depth.height(), kNoSample);
  for (int v = 0; v < depth.height(); ++v)
    for (int u = 0; u < depth.width(); ++u)
      if (depth(u, v) == depth(u, v))
        view.range(u, v) = depth(u, v) / stack.camera.ray(u, v).direction.norm();
  return view;
}

void number_pieces(const GridEdges& edges, FixedSurface& surface) {
  const Grid<float>& depth = surface.depth;
  DisjointSets sets(depth.size());
  const auto at = [&](int u, int v) { return static_cast<std::uint32_t>(depth.index(u, v)); };
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      if (edges.right(u, v)) sets.join(at(u, v), at(u + 1, v));
      if (edges.down(u, v)) sets.join(at(u, v), at(u, v + 1));
    }
  }
  std::vector<std::size_t> sizes(depth.size(), 0);
  for (std::uint32_t i = 0; i < depth.size(); ++i)
    if (depth[i] == depth[i]) ++sizes[sets.find(i)];
  std::vector<std::int32_t> numbers(depth.size(), -1);
  const double smallest = kSmallestPiece * static_cast<double>(depth.size());
  for (std::size_t i = 0; i < depth.size(); ++i)
    if (static_cast<double>(sizes[i]) >= smallest)
      numbers[i] = static_cast<std::int32_t>(surface.pieces++);
  surface.piece = Grid<std::int32_t>(depth.width(), depth.height(), -1);
  for (std::uint32_t i = 0; i < depth.size(); ++i)
    if (depth[i] == depth[i]) surface.piece[i] = numbers[sets.find(i)];
}

}  // namespace

FixedSurface find_fixed_surface(const DepthStack& stack) {
  FixedSurface surface;
  surface.depth = Grid<float>(stack.camera.width(), stack.camera.height(), kNoDepth);
  surface.behind = surface.depth;
  parallel_rows(surface.depth.height(), [&](int v) {
    std::vector<float> depths;
    for (int u = 0; u < surface.depth.width(); ++u) {
      depths_at(stack, u, v, depths);
      surface.depth(u, v) = fixed_depth(depths, stack.tolerance(u, v), stack.size());
      // One view alone that sees farther may be wrong.
      if (!depths.empty()) surface.behind(u, v) = depths.size() > 1 ? depths[1] : depths[0];
    }
  });
  number_pieces(connect_samples(as_view(stack, surface.depth)), surface);
  return surface;
}

Grid<SampleKind> classify_samples(const FixedSurface& surface, const Grid<float>& tolerance,
                                  const Grid<float>& depths) {
  Grid<SampleKind> kinds(depths.width(), depths.height(), SampleKind::kNone);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const float depth = depths[i];
    if (!(depth == depth)) continue;
    const bool stands = surface.piece[i] >= 0;
    // Nearer than what is surely behind it: that moved in front. What is behind all that stands
    // still may be seen here by this view alone.
    if (stands && std::abs(depth - surface.depth[i]) <= tolerance[i])
      kinds[i] = SampleKind::kStanding;
    else if (depth <
             (stands ? surface.depth[i] - tolerance[i] : surface.behind[i] - 2.0f * tolerance[i]))
      kinds[i] = SampleKind::kMoving;
    else
      kinds[i] = SampleKind::kUnknown;
  }
  return kinds;
}

}  // namespace relief
