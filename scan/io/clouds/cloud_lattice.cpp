#include "scan/io/clouds/cloud_lattice.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "scan/base/median.h"
#include "scan/io/clouds/cloud_direction.h"
#include "scan/io/clouds/nearest_points.h"
#include "scan/io/images/image_limits.h"

namespace relief {

namespace {

constexpr std::size_t kQueries = 4000;   // Points whose neighbours are looked at; bounds the time.
constexpr std::size_t kNeighbours = 20;  // Enough for steps that differ by a factor of 4.
// Tangent of the half angle around an axis, 27 degrees: less than the 1 of a square's diagonal.
constexpr double kSector = 0.5;
// Agreement of the neighbours' directions, in [0, 1]: exp(-8 s^2) in rows with scatter s, here 26
// degrees. Without rows 1 / sqrt(4 kQueries) = 0.008.
constexpr double kInRows = 0.2;
// Bounds of the memory: an object may leave 63 of 64 places empty, a small cloud all but its points
// of 500 x 500.
constexpr double kPlacesPerPoint = 64.0, kFewPlaces = 2.5e5;

using Displacements = std::vector<std::vector<Eigen::Vector2d>>;

// To the neighbours of some points, the nearest first.
Displacements displacements(const std::vector<Eigen::Vector2d>& at) {
  const NearestPoints<2> tree(at);
  Displacements all;
  for (const std::size_t i : some_points(at.size(), kQueries)) {
    all.emplace_back();
    for (const auto& neighbour : tree.find(at[i], kNeighbours))
      all.back().push_back(at[neighbour.index] - at[i]);
  }
  return all;
}

// The direction of rows in (-45, 45] degrees, by the fourfold moment of the nearest neighbours'
// directions; 0 where they are not in rows.
double row_angle(const Displacements& all) {
  std::complex<double> moment = 0.0;
  double count = 0.0;
  for (const auto& neighbours : all) {
    for (std::size_t k = 0; k < std::min<std::size_t>(4, neighbours.size()); ++k) {
      const double angle = std::atan2(neighbours[k].y(), neighbours[k].x());
      moment += std::polar(1.0, 4.0 * angle);
      count += 1.0;
    }
  }
  return std::abs(moment) > kInRows * count ? std::arg(moment) / 4.0 : 0.0;
}

// The median distance to the next point along `axis`; 0 where there is none.
double step_along(const Eigen::Vector2d& axis, const Displacements& all) {
  const Eigen::Vector2d across(-axis.y(), axis.x());
  std::vector<double> steps;
  for (const auto& neighbours : all) {
    double least = 0.0;
    for (const auto& d : neighbours) {
      const double along = std::abs(d.dot(axis));
      if (std::abs(d.dot(across)) > kSector * along) continue;
      if (least == 0.0 || along < least) least = along;
    }
    if (least > 0.0) steps.push_back(least);
  }
  return median(steps);
}

struct Interval {
  double low = 0.0, high = 0.0;
  double length() const { return high - low; }
};

// All values, or those within twice the middle 98 % where some are far off.
Interval extent_of(std::vector<double> values, bool trimmed) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const Interval all{*low, *high};
  if (!trimmed) return all;
  const auto at = [&](double fraction) {
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(
                                            fraction * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  const double first = at(0.01), last = at(0.99), margin = 0.5 * (last - first);
  return {std::max(all.low, first - margin), std::min(all.high, last + margin)};
}

// Where points stand between the places of a grid of this step, on average: in [0, 1).
double phase_of(const std::vector<double>& values, double step, double low) {
  std::complex<double> moment = 0.0;
  for (const double value : values)
    moment += std::polar(1.0, 2.0 * std::numbers::pi * (value - low) / step);
  const double phase = std::arg(moment) / (2.0 * std::numbers::pi);
  return phase - std::floor(phase);
}

// One axis of the grid.
struct LatticeAxis {
  std::vector<double> values;
  double step = 0.0;
  Interval extent;

  void limit(bool trimmed) { extent = extent_of(values, trimmed); }
  double places() const { return std::ceil(extent.length() / step) + 2.0; }
  double first() const { return extent.low + (phase_of(values, step, extent.low) - 1.0) * step; }
};

Error no_lattice(const std::string& what) { return {ErrorKind::kUnsolvable, what}; }

// Axes of rows and columns, and the step along each.
struct LatticeSteps {
  Eigen::Vector2d axis_u, axis_v;
  double u = 0.0, v = 0.0;

  bool found() const { return u > 0.0 && v > 0.0; }
};

LatticeSteps lattice_steps(const Displacements& all, bool turned) {
  const double angle = turned ? row_angle(all) : 0.0;
  LatticeSteps steps;
  steps.axis_u = {std::cos(angle), std::sin(angle)};
  steps.axis_v = {-steps.axis_u.y(), steps.axis_u.x()};
  steps.u = step_along(steps.axis_u, all), steps.v = step_along(steps.axis_v, all);
  return steps;
}

}  // namespace

Result<CloudLattice> fit_lattice(const std::vector<Eigen::Vector2d>& at, bool turned) {
  const LatticeSteps steps = lattice_steps(displacements(at), turned);
  const auto& [axis_u, axis_v, step_u, step_v] = steps;
  if (!steps.found())
    return no_lattice("the points lie on a line or at one place; they are no scan of a surface");
  LatticeAxis u, v;
  u.step = step_u, v.step = step_v;
  for (const auto& place : at) {
    u.values.push_back(place.dot(axis_u));
    v.values.push_back(place.dot(axis_v));
  }
  const double most = kPlacesPerPoint * static_cast<double>(at.size()) + kFewPlaces;
  const auto fits = [&] {
    return u.places() * v.places() <= most && std::max(u.places(), v.places()) <= kMaxImageSide;
  };
  u.limit(false), v.limit(false);
  if (!fits()) u.limit(true), v.limit(true);
  if (!fits())
    return no_lattice("the points are too far apart for their spacing; crop them to the object");
  CloudLattice lattice;
  lattice.step_u = u.step * axis_u, lattice.step_v = v.step * axis_v;
  lattice.origin = u.first() * axis_u + v.first() * axis_v;
  lattice.width = static_cast<int>(u.places()), lattice.height = static_cast<int>(v.places());
  return lattice;
}

double part_on_lattice(const std::vector<Eigen::Vector2d>& at) {
  constexpr double kWhole = 1.0 / 7.0;  // [steps] So near by chance: (2 / 7)^2 = 8 %.
  const Displacements all = displacements(at);
  const LatticeSteps steps = lattice_steps(all, true);
  if (!steps.found()) return 0.0;
  const auto whole = [](double value) { return std::abs(value - std::round(value)) < kWhole; };
  double on = 0.0, count = 0.0;
  for (const auto& neighbours : all) {
    for (const auto& d : neighbours) {
      if (whole(d.dot(steps.axis_u) / steps.u) && whole(d.dot(steps.axis_v) / steps.v)) on += 1.0;
      count += 1.0;
    }
  }
  return count > 0.0 ? on / count : 0.0;
}

}  // namespace relief
