#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "registration/pairwise/correspondences.h"
#include "registration/pairwise/degenerate_directions.h"
#include "registration/pairwise/normal_maps/normal_matches.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/page_allocator.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The score of the residuals on one patch of the surface: sum of w r j.
struct PatchScore {
  std::uint64_t patch = 0;
  RigidTangent score = RigidTangent::Zero();
};

/// All residuals of one directed pair of views, compressed to what a Gauss-Newton step needs. A
/// rigid motion of the source by the tangent x and of the target by y, both about a centre common
/// to all views in world axes, changes the whitened residual r of (R3) by j . (x - y) with
///   j = ((p - centre) x n, n) sqrt(w) / sigma,
/// so that one 6x6 matrix serves both views (R11).
struct PairInformation {
  std::size_t source = 0, target = 0;
  Matrix6d information = Matrix6d::Zero();    ///< sum of w j j^T, w the robust weight.
  RigidTangent score = RigidTangent::Zero();  ///< sum of w r j.
  double losses = 0.0;                        ///< sum of rho(r); of normal maps, as linearised.
  std::size_t count = 0;                      ///< Residuals.
  /// The part of the information whose residuals count as independent: that of normal maps, whose
  /// deviation tells what neighbours share.
  Matrix6d independent = Matrix6d::Zero();
  PagedVector<PatchScore> patches;  ///< In ascending order of `patch`.
};

struct PairInformationOptions {
  CorrespondenceOptions search;
  /// Deviation of the pair's residuals [unit], as pair_deviation() has it; 0: that at these poses.
  double sigma = 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< See PairInformation; world frame.
  /// Edge of the cubes that cut the surface into patches [unit]; 0: no patches.
  double patch = 0.0;
};

/// `count` samples of a view's whole surface (0: all), neighbours close to each other in memory.
std::vector<std::uint32_t> in_grid_order(const ViewSurface& view, std::size_t count);

/// Robust standard deviation of a directed pair's residuals at given poses [unit]. Correspondences
/// are those of `search`. 0: the views share nothing.
double pair_deviation(const ViewSurface& source, const ViewSurface& target,
                      const RigidMotion& target_from_source, const CorrespondenceOptions& search);

/// The information of the given samples of the source (grid indices) on the whole target. The
/// caller sets the indices of the two views.
PairInformation pair_information(const ViewSurface& source, const ViewSurface& target,
                                 const RigidMotion& world_from_source,
                                 const RigidMotion& world_from_target,
                                 std::span<const std::uint32_t> samples,
                                 const PairInformationOptions& options);

/// Adds what the normal maps of the pair, matched at `world_from_target`, say of a relative motion
/// `since`, a tangent about `centre`: quadratic, (R9) linearised where they were matched.
void add_normals(const NormalMatchesSpan& normals, const RigidMotion& world_from_target,
                 const Eigen::Vector3d& centre, const RigidTangent& since, PairInformation& sum);

/// Makes the pair indifferent to motions of one view relative to the other. `centre`: that of the
/// pair's tangents.
void ignore_motions(const std::vector<DegenerateDirection>& motions, const Eigen::Vector3d& centre,
                    PairInformation& sum);

}  // namespace relief::registration
