#include "scan/grid/range_quantisation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace relief {

namespace {

// Differences along each direction that the step is looked for in, at least, where there are so
// many. Bounds the time; of 4000, 20 lie below the least of kQuantiles.
constexpr double kEnough = 4000.0;
constexpr std::size_t kFewest = 40;  // By chance 0 +- 0.08 of so many are multiples.

// Errors of a difference of two numbers rounded to single precision, per size of these. Rounding of
// both is one epsilon at most; the rest is for what was computed from them.
constexpr double kRounding = 4.0 * std::numeric_limits<float>::epsilon();

// A difference is a multiple when it is off by no more than this part of the step. By chance a
// fifth of all is, and is subtracted.
constexpr double kOffLattice = 0.1;
// Nor is one whose own error exceeds this part of the step of any use: by chance, three of five
// such are multiples.
constexpr double kMostError = 0.2;
// Differences of more steps say little: errors of the step itself add up. For 16 the step must be
// known to kOffLattice / 16 = 0.6 %.
constexpr double kMostSteps = 16.0;
// This part of the differences must be multiples, beyond those that are by chance: 7 standard
// deviations of chance for kFewest, and reached where up to 22 % of the samples are stray.
constexpr double kMultiples = 0.6;
// Maps that were interpolated, as when they were undistorted or moved into another camera, keep the
// steps between runs of equal ranges. Where two steps meet a linear interpolation leaves two
// samples in between, and one that was done twice four. As many alike are hardly in between.
constexpr std::size_t kShortestRun = 4, kLongestGap = 4;
// Of neighbours this part must be equal for runs to be looked for, which takes all samples: of runs
// with such gaps three in eight are. Ranges that were not rounded have next to none.
constexpr double kEqual = 0.05;
// Runs must be at so many ranges: letters on a plate are runs at two, terraces at a few more.
constexpr std::size_t kLevels = 8;
// Two multiples at least, zero among them, must each be had by this part of the differences. An
// exact plane has one only. Less lets single stray samples count as a second one; more misses
// surfaces that rise by a step at few samples.
constexpr double kCommon = 0.02;

// The number that a sensor may have rounded.
struct Coordinate {
  bool along_ray = false, inverse = false;
  double of(const RangeView& view, int u, int v) const {
    const double t = view.range(u, v);
    const double length = along_ray ? view.camera.ray(u, v).direction.norm() * t : t;
    return inverse ? 1.0 / length : length;
  }
};

struct Difference {
  double value;  // Absolute.
  double error;  // What it may be off by for other reasons than the step.
};
using Differences = std::array<std::vector<Difference>, 2>;  // Along rows, along columns.

int stride_for(const RangeView& view) {
  const double thinning = static_cast<double>(view.sample_count()) / kEnough;
  return std::max(1, static_cast<int>(std::sqrt(thinning)));
}

// `step` is one of the range that is known already: it blurs the multiples of a step of the
// inverse.
Differences differences_of(const RangeView& view, const Coordinate& coordinate, double step,
                           int stride) {
  Differences differences;
  for (const std::size_t axis : {0, 1}) {
    const int du = axis == 0 ? 1 : 0, dv = 1 - du;
    for (int v = 0; v + dv < view.height(); v += stride) {
      for (int u = 0; u + du < view.width(); u += stride) {
        if (!view.has_sample(u, v) || !view.has_sample(u + du, v + dv)) continue;
        const double a = coordinate.of(view, u, v), b = coordinate.of(view, u + du, v + dv);
        const double size = std::max(std::abs(a), std::abs(b));
        if (!std::isfinite(size)) continue;
        differences[axis].push_back({std::abs(a - b), kRounding * size + step * size * size});
      }
    }
  }
  return differences;
}

bool many_are_equal(const Differences& differences) {
  return std::all_of(differences.begin(), differences.end(), [](const auto& along) {
    const auto equal = std::count_if(along.begin(), along.end(), [](const Difference& difference) {
      return difference.value <= difference.error;
    });
    return static_cast<double>(equal) > kEqual * static_cast<double>(along.size());
  });
}

// The coordinates of a row or a column of a view, NaN where there is no sample.
std::vector<double> line_of(const RangeView& view, const Coordinate& coordinate, std::size_t axis,
                            int index) {
  std::vector<double> line(static_cast<std::size_t>(axis == 0 ? view.width() : view.height()),
                           std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < line.size(); ++k) {
    const int along = static_cast<int>(k);
    const int u = axis == 0 ? along : index, v = axis == 0 ? index : along;
    if (view.has_sample(u, v)) line[k] = coordinate.of(view, u, v);
  }
  return line;
}

// A run of equal samples of a line.
struct Run {
  std::size_t begin = 0, end = 0;
  double value = 0.0;
};

// Those that are long enough.
std::vector<Run> runs_of(const std::vector<double>& line) {
  std::vector<Run> runs;
  for (std::size_t begin = 0, end = 0; begin < line.size(); begin = end) {
    const double value = line[begin];
    for (end = begin + 1; end < line.size(); ++end)
      if (!(std::abs(line[end] - value) <= kRounding * value)) break;
    if (end - begin >= kShortestRun) runs.push_back({begin, end, value});
  }
  return runs;
}

// Those of each run to the next one near it and, where that differs, to the one after; `step` as
// above. One step is the most that a smooth surface has from run to run.
void add_differences_of_runs(const std::vector<Run>& runs, double step,
                             std::vector<Difference>& differences) {
  const auto difference = [&](const Run& a, const Run& b) {
    const double size = std::max(a.value, b.value);
    return Difference{std::abs(a.value - b.value), kRounding * size + step * size * size};
  };
  const auto near = [](const Run& a, const Run& b) { return b.begin - a.end <= kLongestGap; };
  for (std::size_t k = 1; k < runs.size(); ++k) {
    if (!near(runs[k - 1], runs[k])) continue;
    differences.push_back(difference(runs[k - 1], runs[k]));
    if (k < 2 || !near(runs[k - 2], runs[k - 1])) continue;
    const Difference over_two = difference(runs[k - 2], runs[k]);
    if (over_two.value > over_two.error) differences.push_back(over_two);
  }
}

// None where the runs are at few ranges, or along one direction only: of an exact plane that leans
// along columns every row is a run.
Differences differences_of_runs(const RangeView& view, const Coordinate& coordinate, double step) {
  Differences differences;
  std::set<double> levels;
  for (const std::size_t axis : {0, 1}) {
    const int lines = axis == 0 ? view.height() : view.width();
    for (int index = 0; index < lines; ++index) {
      const std::vector<Run> runs = runs_of(line_of(view, coordinate, axis, index));
      add_differences_of_runs(runs, step, differences[axis]);
      for (const Run& run : runs) {
        const auto next = levels.lower_bound(run.value * (1.0 - kRounding));
        if (next == levels.end() || *next > run.value * (1.0 + kRounding)) levels.insert(run.value);
      }
    }
  }
  const bool both = std::min(differences[0].size(), differences[1].size()) >= kFewest;
  return both && levels.size() >= kLevels ? differences : Differences();
}

// Of a difference, which is not negative: std::floor is one instruction, std::round is a call.
double nearest_multiple(double difference, double step) {
  return std::floor(difference / step + 0.5);
}

// The least-squares step of the differences up to `most` steps, from a first guess that is off by
// `off` of it.
double improve(const Differences& differences, double step, double most, double off) {
  double products = 0.0, squares = 0.0;
  for (const auto& along : differences) {
    for (const Difference& difference : along) {
      if (difference.value <= difference.error || difference.value > most * step) continue;
      const double multiple = nearest_multiple(difference.value, step);
      if (std::abs(difference.value - multiple * step) > off * step + difference.error) continue;
      products += multiple * difference.value;
      squares += multiple * multiple;
    }
  }
  return squares > 0.0 ? products / squares : 0.0;
}

// The part of the differences along one direction that are multiples of a step, 1 for all and 0 for
// no more than by chance; also 0 where all are the same multiple. Nothing where they say nothing.
std::optional<double> multiples(const std::vector<Difference>& differences, double step) {
  double hits = 0.0, by_chance = 0.0, count = 0.0, nonzero = 0.0;
  std::array<std::size_t, static_cast<std::size_t>(kMostSteps) + 1> of_multiple{};
  for (const Difference& difference : differences) {
    if (difference.error > kMostError * step || difference.value > kMostSteps * step) continue;
    const double off = difference.error + kOffLattice * step;
    const auto multiple = static_cast<std::size_t>(nearest_multiple(difference.value, step));
    const bool zero = difference.value <= difference.error;
    const double gap = std::abs(difference.value - static_cast<double>(multiple) * step);
    const bool hit = zero || (multiple > 0 && gap <= off);
    count += 1.0;
    if (hit) ++of_multiple[zero ? 0 : multiple];
    if (zero) continue;
    nonzero += 1.0;
    hits += hit ? 1.0 : 0.0;
    by_chance += 2.0 * off / step;
  }
  if (nonzero < static_cast<double>(kFewest)) return std::nullopt;
  int common = 0;
  for (const std::size_t n : of_multiple)
    common += static_cast<double>(n) >= kCommon * count ? 1 : 0;
  return common >= 2 ? (hits - by_chance) / (nonzero - by_chance) : 0.0;
}

struct Step {
  double size = 0.0;
  double multiples = 0.0;  // The part of the differences that are.
};

// Those that can improve a first guess of a step, in their order. Up to 4 steps count, and by the
// last of four rounds the step has grown thrice, by half at most: no difference is farther from a
// multiple.
constexpr double kMostImproved = 4.0 * 1.5 * 1.5 * 1.5;
Differences up_to(double most, const Differences& differences) {
  Differences some;
  for (const std::size_t axis : {0, 1})
    std::copy_if(differences[axis].begin(), differences[axis].end(), std::back_inserter(some[axis]),
                 [&](const Difference& difference) { return difference.value <= most; });
  return some;
}

// The largest step that the differences are multiples of; of size 0 for none.
Step find_step(const Differences& differences) {
  // Of the differences, each of which may be one step: those of many steps are above.
  constexpr std::array<double, 7> kQuantiles{0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4};
  std::vector<double> nonzero;
  for (const auto& along : differences)
    for (const Difference& difference : along)
      if (difference.value > difference.error) nonzero.push_back(difference.value);
  if (nonzero.size() < kFewest) return {};
  std::sort(nonzero.begin(), nonzero.end());
  Step largest;
  for (const double quantile : kQuantiles) {
    double step = nonzero[static_cast<std::size_t>(quantile * static_cast<double>(nonzero.size()))];
    const Differences some = up_to(kMostImproved * step, differences);
    for (const auto& [most, off] : {std::pair{1.5, 0.5}, {4.0, 0.25}, {4.0, 0.1}, {4.0, 0.05}})
      step = improve(some, step, most, off);
    if (!(step > largest.size)) continue;
    const auto rows = multiples(differences[0], step), columns = multiples(differences[1], step);
    if (!rows && !columns) continue;
    const double worse = std::min(rows.value_or(1.0), columns.value_or(1.0));
    if (worse >= kMultiples) largest = {step, worse};
  }
  return largest;
}

double median_range(const RangeView& view, bool along_ray) {
  std::vector<double> ranges;
  const Coordinate coordinate{along_ray, false};
  for (int v = 0; v < view.height(); v += 4)
    for (int u = 0; u < view.width(); u += 4)
      if (view.has_sample(u, v)) ranges.push_back(coordinate.of(view, u, v));
  if (ranges.empty()) return 0.0;
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  return *middle;
}

}  // namespace

RangeQuantisation find_quantisation(const RangeView& view) {
  const int stride = stride_for(view);
  for (const bool along_ray : {false, true}) {
    RangeQuantisation found;
    found.along_ray = along_ray;
    const Step step = find_step(differences_of(view, {along_ray, false}, 0.0, stride));
    const Differences inverses = differences_of(view, {along_ray, true}, 0.0, stride);
    Step inverse = find_step(inverses);
    if (step.size > 0.0 && inverse.size == 0.0)
      inverse = find_step(differences_of(view, {along_ray, true}, step.size, stride));
    if (inverse.size == 0.0 && many_are_equal(inverses))
      inverse = find_step(differences_of_runs(view, {along_ray, true}, step.size));
    // Where the range hardly changes the one looks much like the other.
    const double typical = median_range(view, along_ray);
    const double ratio = step.size > 0.0 ? inverse.size * typical * typical / step.size : 2.0;
    const bool alike = ratio > 0.7 && ratio < 1.5;
    if (!alike || step.multiples >= inverse.multiples) found.step = step.size;
    if (ratio >= 1.5 || (alike && found.step == 0.0)) found.inverse_step = inverse.size;
    if (found.exists()) return found;
  }
  return {};
}

}  // namespace relief
