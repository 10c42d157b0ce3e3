#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "registration/surface/view_surface.h"
#include "relief/registration/align_options.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

struct CorrespondenceOptions {
  /// How many to find, at most; the search tries up to `tries` samples for each: an overlap of an
  /// eighth gives them all. Bounds of the time.
  int count = 2000;
  int tries = 8;
  /// Pairs of points farther apart than this are rejected [unit]; > 0.
  double max_distance = 0.0;
  /// Point-to-plane distances beyond this many robust standard deviations of all found are
  /// rejected; 6e-5 of a Gaussian lies beyond four.
  double max_sigmas = 4.0;
  /// Pairs of normals that differ by more than this are rejected [deg]: keeps the two sides of thin
  /// sheets apart.
  double max_normal_angle_deg = 40.0;
  Association association = Association::kAuto;
  /// Of the target, where association is projective; the nearest point is sought on the inner part.
  SurfacePart part = SurfacePart::kInner;
};

/// A sample of the source view and the point of the target's surface that it should lie on, each in
/// its own view's frame.
struct Correspondence {
  SurfacePoint source, target;
  double distance = 0.0;  ///< Point-to-plane distance, equation (R1) [unit].
  double weight = 1.0;    ///< Product of the two confidences.
};

struct Correspondences {
  std::vector<Correspondence> items;
  std::size_t tried = 0;  ///< Samples of the source that were looked for in the target.
  /// Robust standard deviation of the distances before rejection [unit], at least 1e-3 spacings.
  double sigma = 0.0;

  /// Fraction of the source that the target saw too.
  double overlap() const {
    return tried == 0 ? 0.0 : static_cast<double>(items.size()) / static_cast<double>(tried);
  }
};

/// Counterparts of scattered samples of `source` on `target` at a relative pose. Rejected: points
/// that fall on or beyond a boundary of the target, too distant ones, and those with disagreeing
/// normals. Deterministic.
Correspondences find_correspondences(const ViewSurface& source, const ViewSurface& target,
                                     const RigidMotion& target_from_source,
                                     const CorrespondenceOptions& options);

/// The same for the given samples of the source (grid indices), appended to `found`: all of them,
/// however their point-to-plane distances are distributed. `count`, `tries` and `max_sigmas` mean
/// nothing here.
void append_correspondences(const ViewSurface& source, const ViewSurface& target,
                            const RigidMotion& target_from_source,
                            std::span<const std::uint32_t> samples,
                            const CorrespondenceOptions& options,
                            std::vector<Correspondence>& found);

/// Root mean square of the distances [unit]; 0 for none.
double rms_distance(const std::vector<Correspondence>& correspondences);

}  // namespace relief::registration
