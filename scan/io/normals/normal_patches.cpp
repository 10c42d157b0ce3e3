#include "scan/io/normals/normal_patches.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Core>

#include "relief/scan/discontinuities.h"
#include "scan/base/linear_algebra.h"
#include "scan/base/median.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/range_noise.h"
#include "scan/grid/range_quantisation.h"

namespace relief {

namespace {

constexpr int kSmallestRadius = 3, kLargestRadius = 12;  // [pixels]
// [rad], 2 deg that a patch's normal should be good to. Half of it takes windows 1.4 times as wide,
// over which relief bends; twice leaves errors as large as the 4 deg of a sensor's bias.
constexpr double kGoodNormal = 0.035;
constexpr int kMostPatches = 4000;  // bounds the time
constexpr double kCoherent = 0.7;   // Mean length of directions: cos 45 deg of their cone.

// Fits planes to the samples of a window that are connected to its middle inside it.
class WindowFit {
 public:
  WindowFit(const RangeView& view, const Grid<Eigen::Vector3f>& stored, const GridEdges& edges,
            int radius)
      : view_(view),
        stored_(stored),
        edges_(edges),
        radius_(radius),
        reached_(2 * radius + 1, 2 * radius + 1, 0) {}

  // Nothing where the window is less than half full of samples with a stored direction.
  std::optional<NormalPatch> at(int u, int v) {
    if (!view_.has_sample(u, v)) return std::nullopt;
    collect(u, v);
    const double whole = static_cast<double>(reached_.size());
    if (2.0 * directions_ < whole) return std::nullopt;
    NormalPatch patch;
    if (!(mean_stored_.norm() >= kCoherent * directions_)) return std::nullopt;
    patch.stored = mean_stored_.normalized();
    return fit_plane(u, v, patch) ? std::optional(patch) : std::nullopt;
  }

 private:
  void collect(int u, int v) {
    std::fill(reached_.begin(), reached_.end(), std::uint8_t{0});
    mean_stored_.setZero();
    directions_ = 0.0;
    points_.clear();
    queue_.assign(1, {u, v});
    reached_(radius_, radius_) = 1;
    for (std::size_t next = 0; next < queue_.size(); ++next) {
      const auto [pu, pv] = queue_[next];
      points_.push_back(view_.point(pu, pv));
      if (const Eigen::Vector3d d = stored_(pu, pv).cast<double>(); d.allFinite() && d.norm() > 0) {
        mean_stored_ += d.normalized();
        directions_ += 1.0;
      }
      for (const auto& [du, dv] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const int ru = pu + du - u + radius_, rv = pv + dv - v + radius_;
        if (!reached_.contains(ru, rv) || reached_(ru, rv) || !edges_.connected(pu, pv, du, dv))
          continue;
        reached_(ru, rv) = 1;
        queue_.emplace_back(pu + du, pv + dv);
      }
    }
  }

  bool fit_plane(int u, int v, NormalPatch& patch) const {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& point : points_) mean += point;
    const double count = static_cast<double>(points_.size());
    mean /= count;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const auto& point : points_) scatter += (point - mean) * (point - mean).transpose();
    const auto eigen = eigen_decomposition(scatter);
    const Eigen::Vector3d values = eigen.eigenvalues().cwiseMax(0.0);
    if (!(values[1] > 0.0) || count < 4.0) return false;
    // The slope of a plane through samples with errors s across it errs by s / sqrt(sum x^2).
    patch.stddev = std::sqrt(values[0] / (count - 3.0) / values[1]);
    const Eigen::Vector3d normal = eigen.eigenvectors().col(0);
    patch.surface = normal.dot(view_.camera.ray(u, v).direction) > 0.0 ? (-normal).eval() : normal;
    return true;
  }

  const RangeView& view_;
  const Grid<Eigen::Vector3f>& stored_;
  const GridEdges& edges_;
  int radius_;
  Grid<std::uint8_t> reached_;
  std::vector<std::pair<int, int>> queue_;
  std::vector<Eigen::Vector3d> points_;
  Eigen::Vector3d mean_stored_ = Eigen::Vector3d::Zero();
  double directions_ = 0.0;
};

NormalPatches patches_of_radius(const RangeView& view, const Grid<Eigen::Vector3f>& stored,
                                const GridEdges& edges, int radius) {
  const double per_patch = static_cast<double>(view.sample_count()) / kMostPatches;
  const int step = std::max(2 * radius + 1, static_cast<int>(std::sqrt(per_patch)));
  NormalPatches found;
  found.radius = radius;
  found.step = step;
  found.lattice =
      Grid<int>((view.width() + step - 1) / step, (view.height() + step - 1) / step, -1);
  WindowFit window(view, stored, edges, radius);
  for (int row = 0; row < found.lattice.height(); ++row) {
    for (int column = 0; column < found.lattice.width(); ++column) {
      const int u = column * step + step / 2, v = row * step + step / 2;
      if (!view.range.contains(u, v)) continue;
      if (const auto patch = window.at(u, v)) {
        found.lattice(column, row) = static_cast<int>(found.patches.size());
        found.patches.push_back(*patch);
      }
    }
  }
  return found;
}

double median_stddev(const std::vector<NormalPatch>& patches) {
  std::vector<double> all;
  for (const NormalPatch& patch : patches) all.push_back(patch.stddev);
  return median(all);
}

// Standard deviation of the patches' normals by their second differences along rows and columns.
// The residuals of planes do not show errors that neighbouring samples share, such as the steps of
// quantised ranges. Curvature that changes from patch to patch counts as noise, too.
double scatter_between(const NormalPatches& found) {
  const Grid<int>& lattice = found.lattice;
  const auto surface = [&](int column, int row) -> const Eigen::Vector3d& {
    return found.patches[static_cast<std::size_t>(lattice(column, row))].surface;
  };
  std::vector<double> squares;
  for (int row = 0; row < lattice.height(); ++row) {
    for (int column = 0; column < lattice.width(); ++column) {
      for (const auto& [right, down] : {std::pair{1, 0}, {0, 1}}) {
        const int before_u = column - right, before_v = row - down;
        const int after_u = column + right, after_v = row + down;
        if (lattice(column, row) < 0 || !lattice.contains(before_u, before_v) ||
            !lattice.contains(after_u, after_v) || lattice(before_u, before_v) < 0 ||
            lattice(after_u, after_v) < 0)
          continue;
        squares.push_back(
            (surface(before_u, before_v) + surface(after_u, after_v) - 2.0 * surface(column, row))
                .squaredNorm());
      }
    }
  }
  // Six variances along either of two axes; the median of two squares is 2 ln 2 of one.
  return std::sqrt(median(squares) / (6.0 * 2.0 * std::numbers::ln2));
}

// The error of most normals [rad].
double typical_error(const NormalPatches& found) {
  return std::max(median_stddev(found.patches), scatter_between(found));
}

// What windows see of rounded ranges, or of a coarse image that was enlarged by repeating its
// pixels: their samples lie on terraces.
struct Terraces {
  double height = 0.0;   // Of a step along the ray [unit]; 0: none.
  double spacing = 0.0;  // Of samples across the ray [unit].

  // A plane through a window may be off by half a step at its ends.
  double slope_error(int radius) const {
    return height > 0.0 ? 0.5 * height / (spacing * (2 * radius + 1)) : 0.0;
  }
};

// The steps between pixels of a row where most pixels repeat the one before; empty for others.
std::vector<double> steps_between_blocks(const RangeView& view) {
  constexpr double kRepeating = 0.6;  // Of the pairs of neighbours: blocks of 3 pixels have 2/3.
  std::vector<double> steps;
  double pairs = 0.0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u + 1 < view.width(); ++u) {
      if (!view.has_sample(u, v) || !view.has_sample(u + 1, v)) continue;
      const double step = std::abs(view.range(u + 1, v) - view.range(u, v));
      if (step > 0.0) steps.push_back(step * view.camera.ray(u, v).direction.norm());
      pairs += 1.0;
    }
  }
  if (static_cast<double>(steps.size()) > (1.0 - kRepeating) * pairs) steps.clear();
  return steps;
}

Terraces find_terraces(const RangeView& view) {
  const RangeQuantisation quantisation = find_quantisation(view);
  std::vector<double> steps, spacings;
  if (!quantisation.exists()) steps = steps_between_blocks(view);
  if (!quantisation.exists() && steps.empty()) return {};
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u + 1 < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const Ray ray = view.camera.ray(u, v);
      if (quantisation.exists())
        steps.push_back(quantisation.step_at(view.range(u, v), ray.direction.norm()));
      spacings.push_back(
          (view.camera.ray(u + 1, v).at(view.range(u, v)) - view.point(u, v)).norm());
    }
  }
  const double spacing = median(spacings);
  return spacing > 0.0 ? Terraces{median(steps), spacing} : Terraces{};
}

// Steps of the rounding connect like any surface.
GridEdges edges_of(const RangeView& view, const RangeNoise& noise, const Terraces& terraces) {
  DiscontinuityOptions options;
  if (terraces.height > 0.0)
    options.free_step = std::max(options.free_step, 1.5 * terraces.height / terraces.spacing);
  return connect_samples(view, noise, options);
}

// Whether noise makes the samples of a window as thick a cloud as it is wide: planes through them
// may lie anyhow, however well their residuals look.
bool no_flatter_than_wide(const RangeView& view, const RangeNoise& noise, int radius) {
  std::vector<double> spacings;  // Across the rays.
  for (int v = 0; v < view.height(); v += 4)
    for (int u = 0; u + 1 < view.width(); u += 4)
      if (view.has_sample(u, v))
        spacings.push_back(
            (view.camera.ray(u + 1, v).at(view.range(u, v)) - view.point(u, v)).norm());
  const double width = radius * median(spacings) / std::numbers::sqrt3;
  return noise.sigma > 0.5 * width;
}

}  // namespace

NormalPatches find_patches(const RangeView& view, const Grid<Eigen::Vector3f>& stored) {
  const Terraces terraces = find_terraces(view);
  const RangeNoise ranges = estimate_range_noise(view);
  const GridEdges edges = edges_of(view, ranges, terraces);
  NormalPatches found = patches_of_radius(view, stored, edges, kSmallestRadius);
  // The error of noise falls with the square of the window's width, that of terraces with it.
  const double noise = std::sqrt(median_stddev(found.patches) / kGoodNormal);
  const double wider = (2 * kSmallestRadius + 1) *
                       std::max(noise, terraces.slope_error(kSmallestRadius) / kGoodNormal);
  const int radius = std::min(kLargestRadius, static_cast<int>(std::ceil((wider - 1.0) / 2.0)));
  if (radius > kSmallestRadius) {
    NormalPatches coarse = patches_of_radius(view, stored, edges, radius);
    if (!coarse.patches.empty()) found = std::move(coarse);
  }
  constexpr double kAnyDirection = 0.5 * std::numbers::pi;  // [rad]
  double least = std::max(typical_error(found), terraces.slope_error(found.radius));
  if (no_flatter_than_wide(view, ranges, found.radius)) least = std::max(least, kAnyDirection);
  for (NormalPatch& patch : found.patches) patch.stddev = std::max(patch.stddev, least);
  return found;
}

}  // namespace relief
