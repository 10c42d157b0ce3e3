#pragma once

#include <optional>

#include "relief/scan/camera.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "scan/io/grids/grid_file.h"

namespace relief {

/// The view of points that are given on a grid, in the frame of the points: its samples are these
/// points exactly. The rays are those of `camera`, else of the model that fits the points best; see
/// camera_through_points and fit_camera. Normals become unit vectors; those that have no direction
/// (length outside [0.5, 1.5]) or face away from the sensor become NaN. Confidences that are no
/// numbers or negative become 0. A pose of the grid becomes a guess.
///
/// Errors: kBadInput for an empty grid, for one that is not organized (one row), and where `camera`
/// or a grid beside the points has another size; kUnsolvable when no point is finite.
Result<RangeView> view_from_grid(const GridFile& grid, const std::optional<Camera>& camera = {});

/// Gives `view` the normals of a grid of its size as above, in its frame; none for an empty grid.
void set_usable_normals(const Grid<Eigen::Vector3f>& given, RangeView& view);

/// The pose that a viewpoint stands for, as PCD files and PCL's clouds have it: where the sensor is
/// in the world, and the rotation of its axes. Nothing for the identity, which stands for unknown.
/// kBadInput when it is not finite or the quaternion's length differs from 1 by more than
/// kUnitQuaternion.
Result<std::optional<RigidMotion>> pose_from_viewpoint(const Eigen::Vector3f& origin,
                                                       const Eigen::Quaternionf& orientation);

}  // namespace relief
