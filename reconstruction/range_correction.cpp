#include "reconstruction/range_correction.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "scan/grid/filled_view.h"

namespace relief::reconstruction {

namespace {

using Pixel = std::array<int, 2>;

constexpr std::array<Pixel, 4> kSides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

// Samples side by side that have a correction.
std::vector<std::vector<Pixel>> groups_of(const Grid<float>& correction, const RangeView& view) {
  Grid<std::uint8_t> left(view.width(), view.height(), 0);
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = correction[i] == correction[i];
  std::vector<std::vector<Pixel>> groups;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!left(u, v)) continue;
      left(u, v) = 0;
      std::vector<Pixel> group{{u, v}};
      for (std::size_t next = 0; next < group.size(); ++next) {
        for (const auto& [du, dv] : kSides) {
          const Pixel beside{group[next][0] + du, group[next][1] + dv};
          if (!left.contains(beside[0], beside[1]) || !left(beside[0], beside[1])) continue;
          left(beside[0], beside[1]) = 0;
          group.push_back(beside);
        }
      }
      groups.push_back(std::move(group));
    }
  }
  return groups;
}

// Squares of the steps from a group's samples to those beside them, as measured and as moved.
struct Steps {
  double before = 0.0, after = 0.0;
};

Steps steps_of(const std::vector<Pixel>& group, const Grid<double>& corrected,
               const RangeView& view) {
  Steps steps;
  for (const auto& [u, v] : group) {
    for (const auto& [du, dv] : kSides) {
      if (!view.has_sample(u + du, v + dv)) continue;
      const double before = view.range(u, v) - view.range(u + du, v + dv);
      const double after = corrected(u, v) - corrected(u + du, v + dv);
      steps.before += before * before;
      steps.after += after * after;
    }
  }
  return steps;
}

}  // namespace

std::size_t correct_ranges(const Grid<float>& correction, RangeView& view) {
  // Fraction of the squares of the steps that may be left: nearly 0 where what stands apart comes
  // back, 1 and more where the surface was smooth.
  constexpr double kHalf = 0.5;
  const auto largest_flying = static_cast<std::size_t>(FillOptions().largest_flying);
  Grid<double> corrected = view.range;
  for (std::size_t i = 0; i < corrected.size(); ++i)
    if (correction[i] == correction[i]) corrected[i] += double{correction[i]};
  Grid<double> range = view.range;
  std::size_t count = 0;
  for (const auto& group : groups_of(correction, view)) {
    if (group.size() <= largest_flying) continue;
    const Steps steps = steps_of(group, corrected, view);
    if (steps.after > kHalf * steps.before) continue;
    for (const auto& [u, v] : group) range(u, v) = corrected(u, v);
    count += group.size();
  }
  view.range = std::move(range);
  return count;
}

}  // namespace relief::reconstruction
