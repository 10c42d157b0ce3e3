#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "relief/scan/range_view.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::testing {

/// A closed body of radius about `radius` round `centre`: an ellipsoid with smooth bumps that leave
/// no rigid motion undetermined. Found by marching along the ray.
Surface bumpy_object(double radius = 50.0, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero());

/// Views of the bumpy object from all round, with sample spacing near one hundredth of its size.
struct RingOptions {
  int views = 8;
  int pixels = 112;                                  ///< Width and height of a view.
  double radius = 50.0;                              ///< Of the object [unit].
  double noise = 0.3;                                ///< Of the range [sample spacings].
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Of the object, world frame.
  /// Height of the sensor over its distance from the axis, even and odd views.
  std::array<double, 2> tilts = {-0.2, 0.5};
  std::uint32_t seed = 1;
};

/// At their true poses.
std::vector<RangeView> ring_of_views(const RingOptions& options = {});

/// Turns every view but the first by `angle` [rad] about a random axis through the object's centre
/// and moves it by `shift` [unit] in a random direction.
std::vector<RangeView> perturbed(std::vector<RangeView> views, const Eigen::Vector3d& centre,
                                 double angle, double shift, std::uint32_t seed = 7);

/// The views as of a user who has no poses.
std::vector<RangeView> without_poses(std::vector<RangeView> views);

/// For each view the mean distance [unit] of its samples at `estimate` from where they are at
/// `truth`, after the rigid motion common to all views that fits the two best.
std::vector<double> mean_displacements(const std::vector<RangeView>& views,
                                       const std::vector<RigidMotion>& estimate,
                                       const std::vector<RigidMotion>& truth);

std::vector<RigidMotion> poses_of(const std::vector<RangeView>& views);

}  // namespace relief::testing
