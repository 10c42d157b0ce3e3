#include "fusion/views/inter_view_errors.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstddef>
#include <utility>
#include <vector>

#include "fusion/views/view_difference.h"
#include "scan/base/median.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

// Samples that are looked at, of all views. Their median is certain to about 1 %; more cost time.
constexpr std::size_t kSamples = 20'000;

// Differences that make the median mean anything. Fewer come from a rim where views touch.
constexpr std::size_t kFewest = 100;

// Views whose differences tell how the exponent scatters. The error of one view is the same for all
// of its differences, so that of an exponent from three is itself off by a half.
constexpr std::size_t kFewestViews = 4;

// Standard errors by which the exponent is taken too small: what chance does in one of 40 cases.
constexpr double kStandardErrors = 2.0;

// Of no known sensor the noise grows faster: that of triangulation does so with the square.
constexpr double kLargestExponent = 2.0;

// Rounded ranges agree exactly now and then, which has no logarithm [of the median difference].
constexpr double kLeast = 1e-2;

struct SurfacePoint {
  Eigen::Vector3d position, normal;  // World frame.
  double range;                      // From the sensor [unit]; 0 where it has no centre.
  std::size_t view;
};

// Of a sample of one view from the surface of another.
struct Difference {
  double range;     // From both sensors, the geometric mean [unit]; 0 where one has no centre.
  double distance;  // Along the normal, >= 0 [unit].
  auto operator<=>(const Difference&) const = default;
};

std::vector<SurfacePoint> points_of(const ViewSampler& view, std::size_t index, std::size_t count) {
  std::vector<SurfacePoint> points;
  for (const auto& [position, own] : some_samples(view, count))
    points.push_back({position, own.normal, view.range_of(position), index});
  return points;
}

// Of the points of other views from the surface of this one.
std::vector<Difference> differences(const ViewSampler& view, std::size_t index,
                                    const std::vector<SurfacePoint>& points) {
  const double farthest = kFarthest * view.spacing();
  std::vector<Difference> found;
  for (const SurfacePoint& point : points) {
    if (point.view == index) continue;
    const auto quad = view.quad_on_ray_of(point.position);
    if (!quad || view.side(*quad, 2.0 * farthest) != ViewSampler::Side::kNear) continue;
    const auto seen = view.observe(*quad, farthest);
    if (seen && !seen->noisy && seen->border >= kInside &&
        seen->normal.dot(point.normal) > kSameSurfaceCosine && std::abs(seen->distance) < farthest)
      found.push_back({.range = std::sqrt(point.range * view.range_of(point.position)),
                       .distance = std::abs(seen->distance)});
  }
  return found;
}

using Differences = std::vector<std::vector<Difference>>;  // By the view they were looked up in.

// Logarithms of range (x) and distance (y), by view.
std::vector<std::vector<Eigen::Vector2d>> logarithms(const Differences& found, double least) {
  std::vector<std::vector<Eigen::Vector2d>> all;
  for (const auto& of_view : found) {
    all.emplace_back();
    for (const auto& [range, distance] : of_view)
      all.back().emplace_back(std::log(range), std::log(std::max(distance, least)));
  }
  return all;
}

Eigen::Vector2d mean_of(const std::vector<std::vector<Eigen::Vector2d>>& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (const auto& of_view : points) {
    for (const Eigen::Vector2d& point : of_view) sum += point;
    count += static_cast<double>(of_view.size());
  }
  return sum / count;
}

// The exponent by least squares of y = log |N(0, s r^q)| over x = log r, which scatters about
// log s + q x alike for all r. Differences of one view share its error: the standard error of q is
// the sandwich estimate by views (Liang and Zeger 1986).
void fit_exponent(Differences found, RangeErrors& errors) {
  std::erase_if(found, [](const auto& of_view) { return of_view.empty(); });
  if (found.size() < kFewestViews || !(errors.stddev > 0.0)) return;
  // Sums in the order of the values: that of the views does not matter, not even by rounding.
  for (auto& of_view : found) std::sort(of_view.begin(), of_view.end());
  std::sort(found.begin(), found.end());
  for (const auto& of_view : found)
    if (!(of_view.front().range > 0.0)) return;
  auto points = logarithms(found, kLeast * errors.stddev);
  const Eigen::Vector2d mean = mean_of(points);
  double squares = 0.0, products = 0.0;
  for (auto& of_view : points)
    for (Eigen::Vector2d& point : of_view) {
      point -= mean;
      squares += point.x() * point.x();
      products += point.x() * point.y();
    }
  if (!(squares > 0.0)) return;
  const double slope = products / squares;
  double scatter = 0.0;
  for (const auto& of_view : points) {
    double sum = 0.0;
    for (const Eigen::Vector2d& point : of_view) sum += point.x() * (point.y() - slope * point.x());
    scatter += sum * sum;
  }
  const double standard_error = std::sqrt(scatter) / squares;
  errors.typical_range = std::exp(mean.x());
  errors.exponent = std::clamp(slope - kStandardErrors * standard_error, 0.0, kLargestExponent);
}

}  // namespace

RangeErrors inter_view_errors(const std::vector<ViewSampler>& views) {
  RangeErrors errors;
  if (views.size() < 2) return errors;
  const std::size_t each = std::max<std::size_t>(1, kSamples / views.size());
  std::vector<SurfacePoint> points;
  for (auto& of_view : parallel_map<std::vector<SurfacePoint>>(
           views.size(), [&](std::size_t i) { return points_of(views[i], i, each); }))
    points.insert(points.end(), of_view.begin(), of_view.end());
  auto found = parallel_map<std::vector<Difference>>(
      views.size(), [&](std::size_t j) { return differences(views[j], j, points); });
  std::vector<double> distances;
  for (const auto& of_view : found)
    for (const Difference& difference : of_view) distances.push_back(difference.distance);
  if (distances.size() < kFewest) return errors;
  errors.stddev = kSigmaPerMedian * median(std::move(distances)) / std::sqrt(2.0);
  fit_exponent(std::move(found), errors);
  return errors;
}

}  // namespace relief::fusion
