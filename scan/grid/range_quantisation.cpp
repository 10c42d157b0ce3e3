#include "scan/grid/range_quantisation.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
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

// `step` is one of the range that is known already: it blurs the multiples of a step of the
// inverse.
Differences differences_of(const RangeView& view, const Coordinate& coordinate, double step) {
  Differences differences;
  const double thinning = static_cast<double>(view.sample_count()) / kEnough;
  const int stride = std::max(1, static_cast<int>(std::sqrt(thinning)));
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
    for (const auto& [most, off] : {std::pair{1.5, 0.5}, {4.0, 0.25}, {4.0, 0.1}, {4.0, 0.05}})
      step = improve(differences, step, most, off);
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
  for (const bool along_ray : {false, true}) {
    RangeQuantisation found;
    found.along_ray = along_ray;
    const Step step = find_step(differences_of(view, {along_ray, false}, 0.0));
    Step inverse = find_step(differences_of(view, {along_ray, true}, 0.0));
    if (step.size > 0.0 && inverse.size == 0.0)
      inverse = find_step(differences_of(view, {along_ray, true}, step.size));
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
