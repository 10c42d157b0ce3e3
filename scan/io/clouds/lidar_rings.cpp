#include "scan/io/clouds/lidar_rings.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>

namespace relief {

namespace {

// Elevations are counted in bins of 0.1 degrees, and judged in windows of 3. Lidars have steps of
// 0.3 to 2 degrees between their lasers; noise of the range turns no ray.
constexpr std::size_t kWindowBins = 30, kWindows = 60;
constexpr double kFewest = 1.0;  // Points a bin, on the mean of a window that tells something.
// Variance of the counts over their mean: 1 at random. In windows that hold three quarters of the
// points it is 5 and more of lidars, thinned or not, and up to 1.6 of other clouds that were tried.
constexpr double kGathered = 3.0, kPart = 0.25;

using Counts = std::array<double, kWindowBins * kWindows>;

Counts points_by_elevation(const std::vector<Eigen::Vector3d>& points) {
  Counts counts{};
  for (const Eigen::Vector3d& point : points) {
    const double elevation = std::atan2(point.z(), point.head<2>().norm());  // [rad]
    const double place = (elevation / std::numbers::pi + 0.5) * static_cast<double>(counts.size());
    if (point.norm() > 0.0 && place >= 0.0 && place < static_cast<double>(counts.size()))
      counts[static_cast<std::size_t>(place)] += 1.0;
  }
  return counts;
}

// The variance of counts about the line that fits them best, over their mean; nothing where they
// are too few.
std::optional<double> dispersion(std::span<const double> counts) {
  const auto size = static_cast<double>(counts.size());
  const double mean = std::accumulate(counts.begin(), counts.end(), 0.0) / size;
  if (mean < kFewest) return std::nullopt;
  double squares = 0.0, product = 0.0, variance = 0.0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double t = static_cast<double>(i) - 0.5 * (size - 1.0);
    squares += t * t;
    product += t * counts[i];
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double t = static_cast<double>(i) - 0.5 * (size - 1.0);
    variance += std::pow(counts[i] - mean - product / squares * t, 2);
  }
  return variance / (size - 2.0) / mean;
}

}  // namespace

bool on_lidar_rings(const std::vector<Eigen::Vector3d>& points) {
  const Counts counts = points_by_elevation(points);
  double all = 0.0, scattered = 0.0;
  for (std::size_t w = 0; w < kWindows; ++w) {
    const auto window = std::span(counts).subspan(w * kWindowBins, kWindowBins);
    const auto found = dispersion(window);
    if (!found) continue;
    const double number = std::accumulate(window.begin(), window.end(), 0.0);
    all += number;
    if (*found < kGathered) scattered += number;
  }
  return all > 0.0 && scattered < kPart * all;
}

}  // namespace relief
