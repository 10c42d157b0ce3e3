#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "scan/base/memory/paged_array.h"
#include "scan/base/parallel.h"

namespace relief {

/// A partition of the numbers 0 to size - 1 into sets, each of one at first. The representative of
/// a set is its smallest member.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) {
    serial_for(size, [&](std::size_t i) { parent_[i] = static_cast<std::uint32_t>(i); });
  }
  /// The representative of the set that holds `i`.
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// False: they were in one set before.
  bool join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  PagedArray<std::uint32_t> parent_;
};

}  // namespace relief
