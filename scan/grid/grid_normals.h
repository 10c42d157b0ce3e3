#pragma once

#include <Eigen/Core>

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/range_noise.h"

namespace relief {

struct GridNormalOptions {
  /// Half width [pixels] of the window whose samples fit the tangent plane. 1 keeps all detail and
  /// all noise; 2 to 4 suit scans whose noise is near the sample spacing.
  int radius = 2;
  int stride = 1;  ///< Only every stride-th pixel of every stride-th row gets a normal,
  int margin = 0;  ///< and only samples at least so far from boundaries (boundary_distance).
  /// Of the view. Where it is more than a third of what a window is wide, its plane is fitted along
  /// the ray. Not owned; null: all planes are fitted across.
  const RangeNoise* noise = nullptr;
};

/// Unit normals of the measured surface, facing the sensor (N . d < 0), in the view frame; NaN
/// where they are undefined. Each is the normal of the least-squares plane through the samples of a
/// window that are reached from its centre along `edges` without leaving the window: it never mixes
/// the two sides of an occlusion edge. Fewer than three such samples, or collinear ones, give no
/// normal.
///
/// Squared distances are across the plane, which noise turns into the line of sight once it exceeds
/// the width of the window. Such normals are a pattern that moves with the sensor. Distances along
/// the ray, in which the errors are, have no such bias (GridNormalOptions::noise).
Grid<Eigen::Vector3f> estimate_normals(const RangeView& view, const GridEdges& edges,
                                       const GridNormalOptions& options = {});
/// The same where all that it needs to know of the view's grid is at hand.
Grid<Eigen::Vector3f> estimate_normals(const RangeView& view, const ConnectedGrid& grid,
                                       const GridNormalOptions& options = {});

/// Normals from the cross product of the tangents between direct neighbours (central differences
/// inside, one-sided at boundaries): no smoothing at all. Same conventions as estimate_normals.
Grid<Eigen::Vector3f> finite_difference_normals(const RangeView& view, const GridEdges& edges);

}  // namespace relief
