#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "registration/surface/neighbour_index.h"
#include "registration/surface/normal_signal.h"
#include "relief/registration/align_options.h"
#include "relief/scan/discontinuities.h"
#include "relief/scan/page_allocator.h"
#include "relief/scan/range_view.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/range_noise.h"
#include "scan/surface/range_surface.h"

namespace relief::registration {

/// How far a view's surface goes.
enum class SurfacePart {
  kInner,  ///< Up to ViewSurfaceOptions::boundary_margin.
  kWhole,  ///< Up to ViewSurfaceOptions::final_margin.
};

/// A point of a view's surface and its unit normal towards the sensor, in the view frame.
struct SurfacePoint {
  Eigen::Vector3d point, normal;
  /// The sample's confidence; in a view with deviations (median / own deviation)^2 instead.
  double confidence = 1.0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< Where the view sees it.
};

/// The measured normal at a point of a view's surface, freed of its smooth bias.
struct SignalPoint {
  Eigen::Vector3d normal;    ///< Unit, view frame.
  Eigen::Matrix3d gradient;  ///< Its derivative by the position on the surface [rad/unit].
};

/// What alignment needs of a range view, computed once: its surface with smooth normals, samples to
/// match, the noise, the two ways of finding the place that is closest to a point, and the normal
/// map as a signal. Movable; see part() for copies.
class ViewSurface {
 public:
  /// The view outlives the surface with its grids unchanged: ranges are copied only where small
  /// gaps, or samples that hang together with no neighbour, would take half of its usable samples;
  /// these places are bridged (see bridge_gaps).
  explicit ViewSurface(const RangeView& view, const ViewSurfaceOptions& options = {});
  /// The same with `noise` in place of what estimate_range_noise() finds. Views that a calibration
  /// has corrected keep the noise of those given, and its steps, which their ranges show no more.
  ViewSurface(const RangeView& view, const RangeNoise& noise,
              const ViewSurfaceOptions& options = {});
  explicit ViewSurface(const RangeView&& view, const ViewSurfaceOptions& options = {}) = delete;
  ViewSurface(const RangeView&& view, const RangeNoise& noise,
              const ViewSurfaceOptions& options = {}) = delete;
  ViewSurface(ViewSurface&&) = default;
  ViewSurface& operator=(ViewSurface&&) = default;

  /// The same surface with some of its samples() alone to be matched and judged: what others are
  /// compared with stays whole. It shares the memory of this.
  ViewSurface part(std::vector<std::uint32_t> samples) const;

  /// Grid indices of the usable samples (measured, normal, positive confidence, off the boundary,
  /// at most kLargestNoiseRatio times the typical noise) in a scattered order: every prefix is
  /// spread over the whole surface.
  std::span<const std::uint32_t> samples() const { return samples_; }
  /// Those between the two margins, scattered too.
  std::span<const std::uint32_t> edge_samples() const { return edge_samples_; }
  /// The sample at a grid index of samples() or edge_samples().
  SurfacePoint sample(std::uint32_t index) const;

  /// The surface at fractional pixel coordinates: RangeSurface::patch(). Nothing unless the four
  /// samples around are usable.
  std::optional<SurfacePoint> at(const Eigen::Vector2d& pixel,
                                 SurfacePart part = SurfacePart::kInner) const;
  /// The sample nearest to a pixel: cheaper. Nothing where it is not usable.
  std::optional<SurfacePoint> nearest(const Eigen::Vector2d& pixel,
                                      SurfacePart part = SurfacePart::kInner) const;

  /// Resolutions of the normal map, each half as fine as the one before; 0: there is none.
  int signal_levels() const { return signal_levels_; }
  /// The normal map at a point of this surface; nothing where it has gaps. The first call prepares
  /// the map: most shapes need none.
  std::optional<SignalPoint> signal(const SurfacePoint& place, int level) const;

  bool can_project() const { return view().camera.can_project(); }
  /// Constant-time association: the pixel that sees `point`.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const {
    return view().camera.project(point);
  }

  /// The line of sight through a pixel that project() gave, away from the sensor, not normalised.
  Eigen::Vector3d sight(const Eigen::Vector2d& pixel) const {
    return view().camera.ray_at(pixel.x(), pixel.y()).direction;
  }
  /// Whether the view measured nothing at a place of its grid nor within two pixels of it.
  bool blank(const Eigen::Vector2d& pixel) const;

  bool has_neighbour_index() const { return index_ != nullptr; }
  /// For each column the fractional pixel of the inner surface's point closest to it: the nearest
  /// sample, moved within its tangent plane to the foot of the query. Needs the index and a sample.
  std::vector<Eigen::Vector2d> closest(const Eigen::Matrix3Xd& points) const;

  int width() const { return surface_->width(); }         ///< Of the grid [pixels].
  double spacing() const { return surface_->spacing(); }  ///< Median sample spacing [unit].
  /// Standard deviation of the noise of positions along the normal [unit]: of the white part
  /// robustly from third differences, of rounded ranges at least what their steps make; where it
  /// changes over the view, its root mean square.
  double noise() const { return noise_; }
  /// The same of one sample: that of a typical one, and larger where it counts for less.
  double noise_at(const SurfacePoint& sample) const;
  /// Standard deviation of the part of the noise that the rounding of the ranges makes [unit]: all
  /// samples of a terrace share it. 0 where ranges are not rounded.
  double rounding() const { return rounding_; }
  /// Standard deviation of the smoothed geometric normals due to the noise of typical samples
  /// [rad].
  double normal_noise() const { return normal_noise_; }
  /// The same due to the noise of all samples and to terraces of rounded ranges [rad].
  double normal_error() const { return normal_error_; }
  const Eigen::Vector3d& centre() const { return centre_; }  ///< Mean sample, view frame.
  /// Unit mean normal of the samples: roughly towards the sensor, view frame.
  const Eigen::Vector3d& mean_normal() const { return mean_normal_; }
  double radius() const {
    return radius_;
  }  ///< Of the sphere about centre() that holds all samples.

 private:
  ViewSurface(const ViewSurface&) = default;
  const RangeView& view() const { return surface_->view(); }
  int margin(SurfacePart part) const { return part == SurfacePart::kInner ? inner_margin_ : 0; }
  Grid<Eigen::Vector3f> smooth_normals(const RangeView& view, const ConnectedGrid& grid,
                                       const RangeNoise& noise, const Grid<std::uint8_t>& bridged,
                                       const ViewSurfaceOptions& options);
  void select_samples(const Grid<std::uint8_t>& bridged);
  void take_samples(std::vector<std::uint32_t> inner_samples);
  bool is_too_noisy(int u, int v) const;
  SurfacePoint sample(int u, int v) const;
  const NormalSignal& prepared_signal() const;

  struct LazySignal {
    std::once_flag once;
    GridEdges edges;  // Of the view, until the signal is prepared.
    NormalSignal signal;
  };

  // Shared with parts of it.
  std::shared_ptr<const RangeView> filled_;      // The view given with its small gaps bridged.
  std::shared_ptr<const RangeSurface> surface_;  // Of the view given, or of filled_.
  int inner_margin_;                             // [pixels]
  int signal_levels_ = 0;
  std::shared_ptr<LazySignal> signal_ = std::make_shared<LazySignal>();
  PagedVector<std::uint32_t> samples_, edge_samples_;
  std::shared_ptr<const NeighbourIndex> index_;
  double noise_ = 0.0, typical_noise_ = 0.0, rounding_ = 0.0, normal_noise_ = 0.0,
         normal_error_ = 0.0, radius_ = 0.0;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero(), mean_normal_ = Eigen::Vector3d::Zero();
};

/// The median sample spacing of the coarser of two views [unit].
inline double coarser_spacing(const ViewSurface& a, const ViewSurface& b) {
  return std::max(a.spacing(), b.spacing());
}

/// How far `step` moves a point of a view at most [unit]; in the frame in which the view stands at
/// `frame_from_view`.
double largest_motion(const RigidMotion& step, const ViewSurface& view,
                      const RigidMotion& frame_from_view = RigidMotion::Identity());

/// Standard deviation of the distance between two views due to the noise of both [unit].
inline double joint_noise(const ViewSurface& a, const ViewSurface& b) {
  return std::hypot(a.noise(), b.noise());
}

}  // namespace relief::registration
