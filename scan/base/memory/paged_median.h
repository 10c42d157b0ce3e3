#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scan/base/parallel.h"

namespace relief {

/// The median of numbers, the upper one of an even number of them; 0 for none. Counts them by the
/// upper and then by the lower half of their bits: where they lie in files, two passes over these.
inline float paged_median(std::span<const float> values) {
  if (values.empty()) return 0.0f;
  constexpr std::uint32_t kSign = 0x80000000u;
  // Whole numbers in the order of the values.
  const auto key = [](float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return bits & kSign ? ~bits : bits | kSign;
  };
  std::size_t rank = values.size() / 2;
  // The first key part with more than `rank` values up to it; `rank` becomes that among its values.
  const auto select = [&](const auto& part_of) {
    std::vector<std::size_t> count(std::size_t{1} << 16);
    serial_for(values.size(), [&](std::size_t i) {
      if (const int part = part_of(key(values[i])); part >= 0)
        ++count[static_cast<std::size_t>(part)];
    });
    std::uint32_t part = 0;
    for (; rank >= count[part]; ++part) rank -= count[part];
    return part;
  };
  const std::uint32_t upper = select([](std::uint32_t k) { return static_cast<int>(k >> 16); });
  const std::uint32_t lower = select(
      [&](std::uint32_t k) { return k >> 16 == upper ? static_cast<int>(k & 0xffffu) : -1; });
  const std::uint32_t found = upper << 16 | lower;
  return std::bit_cast<float>(found & kSign ? found & ~kSign : ~found);
}

}  // namespace relief
