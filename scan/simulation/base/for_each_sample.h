#pragma once

#include <cstddef>

#include "relief/scan/range_view.h"
#include "scan/base/parallel.h"

namespace relief::simulation {

/// Calls `body(u, v)` for every pixel of `view` that has a sample, in several threads.
template <typename Body>
void for_each_sample(const RangeView& view, const Body& body) {
  parallel_for(static_cast<std::size_t>(view.height()), 8, [&](std::size_t begin, std::size_t end) {
    for (int v = static_cast<int>(begin); v < static_cast<int>(end); ++v)
      for (int u = 0; u < view.width(); ++u)
        if (view.has_sample(u, v)) body(u, v);
  });
}

/// The same row by row in this thread, as for sums.
template <typename Body>
void for_each_sample_in_order(const RangeView& view, const Body& body) {
  on_threads(1, [&] { for_each_sample(view, body); });
}

/// As for_each_sample(), for pixels that also have a normal.
template <typename Body>
void for_each_normal(const RangeView& view, const Body& body) {
  for_each_sample(view, [&](int u, int v) {
    if (view.has_normal(u, v)) body(u, v);
  });
}

/// Takes the sample of a pixel away, and its normal.
inline void lose_sample(RangeView& view, int u, int v) {
  view.range(u, v) = kNoSample;
  if (view.has_normals()) view.normals(u, v).setConstant(static_cast<float>(kNoSample));
}

}  // namespace relief::simulation
