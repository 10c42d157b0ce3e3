#pragma once

#include <string>

#include "relief/scan/camera.h"
#include "relief/scan/grid.h"
#include "scan/io/grids/grid_file.h"

namespace relief {

/// The orthographic camera along `direction` (away from the sensor) whose lattice fits the points
/// best in the least-squares sense. All ranges of the points are positive.
Camera fit_orthographic(const Grid<Eigen::Vector3d>& points, const Eigen::Vector3d& direction);

/// The rays of a projection, away from the sensor along `towards`. All ranges of the points are
/// positive.
Camera rational_camera(const Grid<Eigen::Vector3d>& points, const RationalProjection& projection,
                       const Eigen::Vector3d& towards);

/// The model that explains where the samples lie on the grid best.
struct FittedCamera {
  Camera model;
  std::string description;  ///< Names the model and its residual, for the user.
};

/// Tries, from the simplest to the most general: pinhole and pinhole_gl, orthographic in the
/// direction the points suggest, a rational projection (perspective of any pose, line scanners),
/// and a spherical one where the others fail. The first whose residual is not clearly worse than
/// the best is taken. Which of the two ways along a ray leads away from the sensor follows from, in
/// this order: the perspective (rays part away from the sensor), measured normals (they face the
/// sensor; see normals_tell_side), and the custom of range-grid files that z points towards the
/// viewer.
FittedCamera fit_camera(const GridFile& grid);

/// The orthographic candidate of fit_camera alone.
FittedCamera fit_orthographic(const GridFile& grid);

}  // namespace relief
