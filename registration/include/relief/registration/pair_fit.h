#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What a pair of views is worth by itself.
enum class PairStatus {
  kDetermined,  ///< It fits and determines all six motions.
  kDegenerate,  ///< It fits, but leaves motions free: other pairs have to hold them.
  kThin,        ///< It fits, but on less than a tenth of the views or 200 samples.
  kMisfit,      ///< It deviates by more than noise and sampling explain: see largest_fitting_rms().
};

/// A motion that slides the surface along itself: nothing in its shape tells how far.
struct DegenerateDirection {
  /// Rotation [rad] and translation [unit] of the point `centre`; the larger of |rotation| and
  /// |translation| / radius is about 1.
  RigidTangent motion = RigidTangent::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  /// For people: `sliding along (x y z)`, `turning about (x y z) through (x y z)`, or a screw.
  std::string description;
};

/// How two views fit at the refined poses.
struct PairFit {
  std::size_t a = 0, b = 0;  ///< Indices of the views; a < b.
  double overlap = 0.0;  ///< Fraction of samples seen by the other view, mean of both directions.
  double rms = 0.0;      ///< Of the point-to-plane distances [unit].
  std::size_t correspondences = 0;  ///< Both directions together.
  PairStatus status = PairStatus::kDetermined;
  bool normal_maps = false;  ///< Whether normal maps were aligned, (R9).
  /// Motions (world frame) that this pair alone would not determine.
  std::vector<DegenerateDirection> degenerate_directions;
};

/// `firm` (kDetermined), `degenerate`, `thin` or `misfit`.
std::string_view to_string(PairStatus status);

}  // namespace relief::registration
