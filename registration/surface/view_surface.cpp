#include "registration/surface/view_surface.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "registration/surface/bridged_view.h"
#include "registration/surface/sample_weights.h"
#include "registration/surface/unbiased_normals.h"
#include "registration/surface/view_noise.h"
#include "relief/scan/discontinuities.h"
#include "scan/base/counter_random.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/grid_normals.h"
#include "scan/grid/range_noise.h"

namespace relief::registration {

namespace {

// The largest window is the smallest where noise of one spacing leaves less (slope_noise() is 0.029
// at 5 and 0.043 at 4).
constexpr double kWantedNormalNoise = 0.035;                        // [rad], two degrees
constexpr int kSmallestNormalRadius = 2, kLargestNormalRadius = 5;  // [pixels]
// Rounded ranges make terraces. A window as wide as this many steps of the range sees several of
// them on all but nearly frontal surfaces. [steps], [pixels]
constexpr double kTerraces = 1.5;
constexpr int kLargestTerraceRadius = 8;
// Noise of more than this part of a step dithers the rounding: its errors are white then, and are
// in the noise already. Means of rounded ranges err by exp(-2 pi^2 / 4) / pi = 0.002 steps at most.
constexpr double kDither = 0.5;
constexpr int kBlankReach = 2;  // [pixels] of (R15)

// Sorts indices by the upper half of what they scatter to, without a random generator.
void scatter(std::vector<std::uint32_t>& indices) {
  std::vector<std::uint64_t> keys;
  keys.reserve(indices.size());
  for (const std::uint32_t i : indices)
    keys.push_back((CounterRandom::scrambled(i) & ~0xffffffffull) | i);
  std::sort(keys.begin(), keys.end());
  std::transform(keys.begin(), keys.end(), indices.begin(),
                 [](std::uint64_t key) { return static_cast<std::uint32_t>(key); });
}

int normal_radius(double noise, double spacing, double step) {
  int radius = kSmallestNormalRadius;
  while (radius < kLargestNormalRadius && slope_noise(noise, spacing, radius) > kWantedNormalNoise)
    ++radius;
  if (step > 0.0 && spacing > 0.0)
    radius = std::max(radius, static_cast<int>(std::ceil(std::min<double>(
                                  kLargestTerraceRadius, kTerraces * step / spacing))));
  return radius;
}

// Slopes of terraces [rad]: over a window of half width `radius` [pixels] the rounding of the
// ranges does not average out.
double terrace_slope(double rounding, double spacing, int radius) {
  return spacing > 0.0 ? rounding / (spacing * radius) : 0.0;
}

}  // namespace

ViewSurface::ViewSurface(const RangeView& given, const ViewSurfaceOptions& options)
    : ViewSurface(given, estimate_range_noise(given), options) {}

ViewSurface::ViewSurface(const RangeView& given, const RangeNoise& noise,
                         const ViewSurfaceOptions& options)
    : inner_margin_(options.boundary_margin) {
  assert(options.boundary_margin >= 1 && options.final_margin >= 1);
  ConnectedGrid grid = connect_grid(given, noise);
  Grid<std::uint8_t> bridged;
  if (auto filled = bridge_gaps(given, noise, grid, inner_margin_)) {
    filled_ = std::make_shared<const RangeView>(std::move(filled->view));
    grid = std::move(filled->grid);
    bridged = std::move(filled->bridged);
  }
  const RangeView& view = filled_ ? *filled_ : given;
  const auto normals = smooth_normals(view, grid, noise, bridged, options);
  const bool geometric = options.normals == NormalSource::kGeometric;
  surface_ = std::make_shared<const RangeSurface>(
      view, grid, normals, geometric ? sample_weights(view, noise) : Grid<float>());
  select_samples(bridged);
  if (options.normal_signal && view.has_normals()) {
    signal_levels_ = NormalSignal::levels_of(view.width(), view.height());
    signal_->edges = std::move(grid.edges);
  }
  if (samples_.empty() || (can_project() && !options.neighbour_index)) return;
  Eigen::Matrix3Xd points(3, samples_.size());
  for (std::size_t i = 0; i < samples_.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = sample(samples_[i]).point;
  index_ = std::make_shared<const NeighbourIndex>(points);
}

// Finds the noise of the view as well, which the window of the normals depends on.
Grid<Eigen::Vector3f> ViewSurface::smooth_normals(const RangeView& view, const ConnectedGrid& grid,
                                                  const RangeNoise& ranges,
                                                  const Grid<std::uint8_t>& bridged,
                                                  const ViewSurfaceOptions& options) {
  const double spacing = sample_spacing(grid.points, grid.edges);
  noise_ = position_noise(view, grid, ranges);
  double step = typical_step(view, ranges);
  const auto radius_for = [&] {
    return options.normal_radius > 0 ? options.normal_radius : normal_radius(noise_, spacing, step);
  };
  if (step > 0.0) {
    // Differences of rounded ranges are mostly zero: the ranges as a whole tell more.
    const auto coarse =
        estimate_normals(view, grid, {.radius = radius_for(), .stride = 4, .noise = &ranges});
    const double incidence = typical_incidence(view, coarse);
    if (noise_ >= kDither * step * incidence) {
      step = 0.0;
    } else {
      noise_ = std::max(noise_, ranges.sigma * incidence);
      rounding_ = step / std::sqrt(12.0) * incidence;
    }
  }
  const int radius = radius_for();
  normal_noise_ = slope_noise(noise_, spacing, radius);
  typical_noise_ = std::max(noise_, rounding_);
  noise_ = std::max(noise_ * noise_ratio(view, ranges), rounding_);
  normal_error_ =
      std::hypot(slope_noise(noise_, spacing, radius), terrace_slope(rounding_, spacing, radius));
  const int outermost = std::min(options.boundary_margin, options.final_margin);
  auto normals =
      estimate_normals(view, grid, {.radius = radius, .margin = outermost, .noise = &ranges});
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (grid.boundary[i] < outermost)
      normals[i].setConstant(std::numeric_limits<float>::quiet_NaN());
    else if (options.normals == NormalSource::kMeasured && view.has_normals() &&
             view.normals[i].allFinite() && (bridged.empty() || !bridged[i]))
      normals[i] = view.normals[i];
  }
  return normals;
}

const NormalSignal& ViewSurface::prepared_signal() const {
  std::call_once(signal_->once, [this] {
    const UnbiasedNormalOptions options{.noise = noise_, .spacing = spacing()};
    const GridEdges edges = std::move(signal_->edges);
    signal_->signal = NormalSignal(unbiased_normals(view(), edges, options));
  });
  return signal_->signal;
}

void ViewSurface::select_samples(const Grid<std::uint8_t>& bridged) {
  std::vector<std::uint32_t> inner_samples, edge_samples;
  surface_->for_each_sample([&](int u, int v) {
    const auto index = static_cast<std::uint32_t>(v * width() + u);
    if ((!bridged.empty() && bridged[index]) || is_too_noisy(u, v)) return;
    const bool inner = surface_->boundary_distance(u, v) >= inner_margin_;
    (inner ? inner_samples : edge_samples).push_back(index);
  });
  scatter(edge_samples);
  edge_samples_.assign(edge_samples.begin(), edge_samples.end());
  take_samples(std::move(inner_samples));
}

void ViewSurface::take_samples(std::vector<std::uint32_t> inner_samples) {
  centre_.setZero();
  mean_normal_.setZero();
  radius_ = 0.0;
  if (!inner_samples.empty()) {
    // Relative to one sample, so that a view far from its own origin loses nothing.
    const Eigen::Vector3d first = sample(inner_samples.front()).point;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const std::uint32_t i : inner_samples) {
      const SurfacePoint point = sample(i);
      sum += point.point - first;
      mean_normal_ += point.normal;
    }
    mean_normal_.normalize();
    centre_ = first + sum / static_cast<double>(inner_samples.size());
    for (const std::uint32_t i : inner_samples)
      radius_ = std::max(radius_, (sample(i).point - centre_).norm());
  }
  scatter(inner_samples);
  samples_.assign(inner_samples.begin(), inner_samples.end());
}

ViewSurface ViewSurface::part(std::vector<std::uint32_t> samples) const {
  ViewSurface part = *this;
  std::sort(samples.begin(), samples.end());
  part.edge_samples_.clear();
  part.take_samples(std::move(samples));
  return part;
}

// Whether its noise leaves a sample less than a hundredth of the weight of a typical one.
bool ViewSurface::is_too_noisy(int u, int v) const {
  return surface_->weight(u, v) * kLargestNoiseRatio * kLargestNoiseRatio <
         std::min(1.0f, view().confidence_at(u, v));
}

SurfacePoint ViewSurface::sample(int u, int v) const {
  return {surface_->point(u, v), surface_->normal(u, v), surface_->weight(u, v),
          Eigen::Vector2d(u, v)};
}

double ViewSurface::noise_at(const SurfacePoint& sample) const {
  return sample.confidence > 0.0 ? typical_noise_ / std::sqrt(sample.confidence) : noise_;
}

SurfacePoint ViewSurface::sample(std::uint32_t index) const {
  const int width = view().width();
  return sample(static_cast<int>(index) % width, static_cast<int>(index) / width);
}

std::optional<SurfacePoint> ViewSurface::at(const Eigen::Vector2d& pixel, SurfacePart part) const {
  const auto quad = surface_->quad_at(pixel, margin(part));
  const auto patch = quad ? surface_->patch(*quad) : std::nullopt;
  if (!patch) return std::nullopt;
  return SurfacePoint{patch->point(), patch->normal, patch->weight, pixel};
}

std::optional<SurfacePoint> ViewSurface::nearest(const Eigen::Vector2d& pixel,
                                                 SurfacePart part) const {
  const double u = std::round(pixel.x()), v = std::round(pixel.y());
  if (!(u >= 0.0 && v >= 0.0 && u < view().width() && v < view().height())) return std::nullopt;
  if (!surface_->has_sample(static_cast<int>(u), static_cast<int>(v), margin(part)))
    return std::nullopt;
  return sample(static_cast<int>(u), static_cast<int>(v));
}

std::optional<SignalPoint> ViewSurface::signal(const SurfacePoint& place, int level) const {
  const auto sample = prepared_signal().at(place.pixel, level);
  if (!sample) return std::nullopt;
  // Where the rays of the next pixels meet the tangent plane: steps free of the noise of samples.
  const auto step_to = [&](double u, double v) -> Eigen::Vector3d {
    const Ray ray = view().camera.ray_at(u, v);
    const double t = place.normal.dot(place.point - ray.origin) / place.normal.dot(ray.direction);
    return ray.at(t) - place.point;
  };
  Eigen::Matrix<double, 3, 2> steps;
  steps << step_to(place.pixel.x() + 1.0, place.pixel.y()),
      step_to(place.pixel.x(), place.pixel.y() + 1.0);
  const Eigen::Matrix2d metric = steps.transpose() * steps;
  return SignalPoint{sample->normal, sample->by_pixel * metric.inverse() * steps.transpose()};
}

bool ViewSurface::blank(const Eigen::Vector2d& pixel) const {
  const double u = std::round(pixel.x()), v = std::round(pixel.y());
  if (!(u >= 0.0 && v >= 0.0 && u < view().width() && v < view().height())) return false;
  const int left = std::max(0, static_cast<int>(u) - kBlankReach);
  const int top = std::max(0, static_cast<int>(v) - kBlankReach);
  const int right = std::min(view().width() - 1, static_cast<int>(u) + kBlankReach);
  const int bottom = std::min(view().height() - 1, static_cast<int>(v) + kBlankReach);
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x)
      if (!std::isnan(view().range(x, y))) return false;
  return true;
}

std::vector<Eigen::Vector2d> ViewSurface::closest(const Eigen::Matrix3Xd& points) const {
  assert(index_);
  const std::vector<int> nearest = index_->nearest(points);
  std::vector<Eigen::Vector2d> pixels(nearest.size());
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const std::uint32_t index = samples_[static_cast<std::size_t>(nearest[i])];
    const int u = static_cast<int>(index) % view().width();
    const int v = static_cast<int>(index) / view().width();
    // Usable samples are off the boundary, so their neighbours exist and are connected.
    const auto point = [&](int x, int y) { return view().point(x, y); };
    Eigen::Matrix<double, 3, 2> tangents;
    tangents.col(0) = 0.5 * (point(u + 1, v) - point(u - 1, v));
    tangents.col(1) = 0.5 * (point(u, v + 1) - point(u, v - 1));
    const Eigen::Vector3d offset = points.col(static_cast<Eigen::Index>(i)) - point(u, v);
    const Eigen::Vector2d step =
        (tangents.transpose() * tangents).inverse() * (tangents.transpose() * offset);
    // Never further than to the neighbouring samples: beyond, another sample would be the nearest.
    pixels[i] = Eigen::Vector2d(u, v) + step.cwiseMax(-1.0).cwiseMin(1.0);
  }
  return pixels;
}

double largest_motion(const RigidMotion& step, const ViewSurface& view,
                      const RigidMotion& frame_from_view) {
  const Eigen::Vector3d centre = frame_from_view * view.centre();
  return (step * centre - centre).norm() + rotation_angle(step) * view.radius();
}

}  // namespace relief::registration
