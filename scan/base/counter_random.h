#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace relief {

/// Random numbers as a pure function of (seed, stream, index): the same on every platform and with
/// any number of threads, since nothing depends on the order of calls. The generator is SplitMix64
/// (Steele, Lea and Flood 2014) with its state computed from the counter.
class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, std::uint64_t stream)
      : key_(scrambled(scrambled(seed + kGolden) ^ (stream * 0xd1342543de82ef95ull))) {}

  std::uint64_t bits(std::uint64_t index) const { return scrambled(key_ + (index + 1) * kGolden); }

  /// Uniform in the open interval (0, 1).
  double uniform(std::uint64_t index) const {
    return (static_cast<double>(bits(index) >> 12) + 0.5) * 0x1p-52;
  }

  /// Standard normal (Box and Muller 1958), from the uniforms 2 index and 2 index + 1.
  double normal(std::uint64_t index) const {
    const double radius = std::sqrt(-2.0 * std::log(uniform(2 * index)));
    return radius * std::cos(2.0 * std::numbers::pi * uniform(2 * index + 1));
  }

  /// A bijection of 64-bit integers whose outputs look random: the finaliser of SplitMix64.
  static std::uint64_t scrambled(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }

 private:
  static constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ull;

  std::uint64_t key_;
};

}  // namespace relief
