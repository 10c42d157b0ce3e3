#pragma once

#include <Eigen/Core>

#include "fusion/holes/fair_regions.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

/// Rings of measured vertices beyond the margin of a region that tell how the surface curves
/// towards its border.
inline constexpr int kApproachRings = 6;

/// How the surface arrives at a region's border, and has to turn across it.
struct BorderBend {
  bool known = false;
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();  ///< The direction that the region faces.
  double turn = 0.0;                                 ///< From the border to there [rad].
  double carried = 0.0;    ///< By how much the surface would turn as it curves, straight (F8).
  double on_sphere = 0.0;  ///< The same along the way across a sphere through the border.
};

/// How far the middle of a region lies behind the tangent planes of its border, on average, against
/// its distance: negative in a valley.
double behind_border(const TriangleMesh& mesh, const FairRegion& region);

/// `voxel`: length of the edges of the mesh [unit].
BorderBend bend_at_border(const MeshRings& of, const FairRegion& region, double voxel);

/// Adds the rings beyond the border, but for the last, to `region.approach`.
void add_approach(const MeshRings& of, FairRegion& region);

}  // namespace relief::fusion
