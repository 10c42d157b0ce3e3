#pragma once

#include <cstdint>

namespace relief {

/// Three integers in one, 21 bits each, of which `x` is the lowest: keys order by z, then y, then x
/// where none is negative. Integers that differ by a multiple of 2^21 share a key.
inline std::uint64_t cell_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr std::int64_t kMask = (std::int64_t{1} << 21) - 1;
  return static_cast<std::uint64_t>((x & kMask) | (y & kMask) << 21 | (z & kMask) << 42);
}

}  // namespace relief
