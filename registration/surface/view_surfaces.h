#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "registration/surface/view_surface.h"
#include "relief/scan/context.h"
#include "scan/base/memory/memory_limit.h"
#include "scan/base/parallel.h"

namespace relief::registration {

/// The surfaces `make(0)` to `make(count - 1)`: one for each thread at a time, under a memory limit
/// a single one. `report` is told the part that is made; nothing where it returns false.
template <typename Make, typename Report>
std::optional<std::vector<ViewSurface>> make_surfaces(std::size_t count, const Make& make,
                                                      const Report& report) {
  const auto at_once =
      current_memory_limit() ? std::size_t{1} : static_cast<std::size_t>(thread_count());
  std::vector<ViewSurface> surfaces;
  surfaces.reserve(count);
  while (surfaces.size() < count) {
    const std::size_t begin = surfaces.size();
    if (!report(static_cast<double>(begin) / static_cast<double>(count))) return std::nullopt;
    auto made = parallel_map<std::optional<ViewSurface>>(
        std::min(at_once, count - begin), [&](std::size_t i) { return make(begin + i); });
    for (std::optional<ViewSurface>& surface : made) surfaces.push_back(*std::move(surface));
  }
  return surfaces;
}

}  // namespace relief::registration
