#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "relief/scan/projections.h"
#include "scan/base/median.h"
#include "scan/views/projection_fits.h"

namespace relief {

namespace {

constexpr double kFullTurn = 2.0 * std::numbers::pi;
constexpr double kUnknownAngle = std::numeric_limits<double>::quiet_NaN();

// Even angles are taken where they project the samples almost as well as the tables of medians.
// Medians of n samples fit even angles with noise better by 0.2 / n only: 1.1 is far beyond chance.
constexpr double kEvenIsAsGood = 1.1;   // ratio of residuals
constexpr double kEvenResidual = 0.01;  // pixels; a fiftieth of what names the pixel beside

double angle_at(const std::vector<double>& angles, double place) {
  const auto last = static_cast<double>(angles.size() - 1);
  const auto before = static_cast<std::size_t>(std::clamp(std::floor(place), 0.0, last - 1.0));
  const double part = place - static_cast<double>(before);
  return angles[before] + part * (angles[before + 1] - angles[before]);
}

// The place of an angle in a strictly growing or falling table; beyond its ends by the step there.
double place_of(const std::vector<double>& angles, double angle) {
  const bool growing = angles.back() > angles.front();
  const auto after = std::lower_bound(
      angles.begin() + 1, angles.end() - 1, angle,
      [growing](double entry, double value) { return growing ? entry < value : entry > value; });
  const auto before = after - 1;
  return static_cast<double>(before - angles.begin()) + (angle - *before) / (*after - *before);
}

bool strictly_monotone(const std::vector<double>& angles) {
  if (angles.size() < 2) return false;
  const double sign = angles[1] > angles[0] ? 1.0 : -1.0;
  for (std::size_t i = 0; i + 1 < angles.size(); ++i)
    if (!(sign * (angles[i + 1] - angles[i]) > 0.0)) return false;
  return std::isfinite(angles.front()) && std::isfinite(angles.back());
}

double wrapped(double angle) { return std::remainder(angle, kFullTurn); }

double azimuth_of(const Eigen::Vector3d& point) { return std::atan2(point.y(), point.x()); }

double elevation_of(const Eigen::Vector3d& point) {
  return std::atan2(point.z(), std::hypot(point.x(), point.y()));
}

bool is_away_from_origin(const Eigen::Vector3d& point) {
  return point.allFinite() && point.squaredNorm() > 0.0;
}

// The median of angles, taken round their mean direction. Points near the axis have no certain
// azimuth: the mean weighs each by its distance from the axis.
double median_azimuth(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& point : points) mean += point.head<2>() / point.norm();
  if (!(mean.squaredNorm() > 0.0)) return kUnknownAngle;
  const double centre = std::atan2(mean.y(), mean.x());
  std::vector<double> deviations;
  for (const auto& point : points)
    if (point.head<2>().norm() > 0.1 * point.norm())
      deviations.push_back(wrapped(azimuth_of(point) - centre));
  return deviations.empty() ? centre : centre + median(deviations);
}

// Whole turns are added so that each known angle is nearest to the known one before it.
void unwrap(std::vector<double>& angles) {
  double before = kUnknownAngle;
  for (double& angle : angles) {
    if (std::isnan(angle)) continue;
    if (!std::isnan(before)) angle = before + wrapped(angle - before);
    before = angle;
  }
}

// False when fewer than two angles are known. Unknown ones lie evenly between known ones, and go on
// at the ends with the mean step.
bool fill_unknown(std::vector<double>& angles) {
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < angles.size(); ++i)
    if (!std::isnan(angles[i])) known.push_back(i);
  if (known.size() < 2) return false;
  const auto distance = [](std::size_t from, std::size_t to) {
    return static_cast<double>(to) - static_cast<double>(from);
  };
  const double step =
      (angles[known.back()] - angles[known.front()]) / distance(known.front(), known.back());
  for (std::size_t i = 0; i < known.front(); ++i)
    angles[i] = angles[known.front()] - step * distance(i, known.front());
  for (std::size_t i = known.back() + 1; i < angles.size(); ++i)
    angles[i] = angles[known.back()] + step * distance(known.back(), i);
  for (std::size_t k = 0; k + 1 < known.size(); ++k)
    for (std::size_t i = known[k] + 1; i < known[k + 1]; ++i)
      angles[i] = std::lerp(angles[known[k]], angles[known[k + 1]],
                            distance(known[k], i) / distance(known[k], known[k + 1]));
  return true;
}

std::optional<SphericalProjection> median_angles(const Grid<Eigen::Vector3d>& points) {
  SphericalProjection projection;
  std::vector<Eigen::Vector3d> line;
  for (int u = 0; u < points.width(); ++u) {
    line.clear();
    for (int v = 0; v < points.height(); ++v)
      if (is_away_from_origin(points(u, v))) line.push_back(points(u, v));
    projection.azimuth.push_back(median_azimuth(line));
  }
  std::vector<double> elevations;
  for (int v = 0; v < points.height(); ++v) {
    elevations.clear();
    for (int u = 0; u < points.width(); ++u)
      if (is_away_from_origin(points(u, v))) elevations.push_back(elevation_of(points(u, v)));
    projection.elevation.push_back(elevations.empty() ? kUnknownAngle : median(elevations));
  }
  unwrap(projection.azimuth);
  if (!fill_unknown(projection.azimuth) || !fill_unknown(projection.elevation)) return std::nullopt;
  return projection;
}

// The straight line through a table, by least squares.
std::vector<double> evened(const std::vector<double>& angles) {
  const auto n = static_cast<double>(angles.size());
  const double middle = 0.5 * (n - 1.0);
  double mean = 0.0, moment = 0.0;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    mean += angles[i] / n;
    moment += (static_cast<double>(i) - middle) * angles[i];
  }
  const double step = 12.0 * moment / (n * (n * n - 1.0));
  std::vector<double> even(angles.size());
  for (std::size_t i = 0; i < angles.size(); ++i)
    even[i] = mean + step * (static_cast<double>(i) - middle);
  return even;
}

}  // namespace

SphericalProjection SphericalProjection::even(int width, int height, double azimuth,
                                              double azimuth_step, double elevation,
                                              double elevation_step) {
  SphericalProjection projection;
  for (int u = 0; u < width; ++u) projection.azimuth.push_back(azimuth + u * azimuth_step);
  for (int v = 0; v < height; ++v) projection.elevation.push_back(elevation + v * elevation_step);
  return projection;
}

bool SphericalProjection::valid() const {
  const double quarter = 0.25 * kFullTurn * (1.0 + 1e-6), turn = kFullTurn * (1.0 + 1e-6);
  return strictly_monotone(azimuth) && strictly_monotone(elevation) &&
         std::abs(azimuth.back() - azimuth.front()) <= turn &&
         std::abs(elevation.front()) <= quarter && std::abs(elevation.back()) <= quarter;
}

Ray SphericalProjection::ray(double u, double v) const {
  const double a = angle_at(azimuth, u), e = angle_at(elevation, v);
  return {Eigen::Vector3d::Zero(),
          {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)}};
}

std::optional<Eigen::Vector2d> SphericalProjection::project(const Eigen::Vector3d& point) const {
  if (point.x() == 0.0 && point.y() == 0.0) return std::nullopt;
  const double middle = 0.5 * (azimuth.front() + azimuth.back());
  const double a = middle + wrapped(azimuth_of(point) - middle);
  return Eigen::Vector2d(place_of(azimuth, a), place_of(elevation, elevation_of(point)));
}

double SphericalProjection::rms_pixels(const Grid<Eigen::Vector3d>& points) const {
  double squares = 0.0, count = 0.0;
  for (int v = 0; v < points.height(); ++v) {
    for (int u = 0; u < points.width(); ++u) {
      if (!is_away_from_origin(points(u, v))) continue;
      const auto pixel = project(points(u, v));
      if (!pixel) continue;
      const double narrow = points(u, v).head<2>().norm() / points(u, v).norm();
      squares += std::pow(narrow * (pixel->x() - u), 2) + std::pow(pixel->y() - v, 2);
      count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(squares / count) : std::numeric_limits<double>::infinity();
}

std::optional<SphericalProjectionFit> fit_spherical_projection(
    const Grid<Eigen::Vector3d>& points) {
  const auto medians = median_angles(points);
  if (!medians) return std::nullopt;
  const SphericalProjection even{evened(medians->azimuth), evened(medians->elevation)};
  const double even_residual =
      even.valid() ? even.rms_pixels(points) : std::numeric_limits<double>::infinity();
  const double residual =
      medians->valid() ? medians->rms_pixels(points) : std::numeric_limits<double>::infinity();
  if (even_residual <= std::max(kEvenResidual, kEvenIsAsGood * residual) &&
      std::isfinite(even_residual))
    return SphericalProjectionFit{even, even_residual};
  if (!std::isfinite(residual)) return std::nullopt;
  return SphericalProjectionFit{*medians, residual};
}

}  // namespace relief
