#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace relief::registration {

/// A point that may be on a plane; any frame.
struct PlaneProbe {
  Eigen::Vector3d point, normal;
  double tolerance;  ///< Distance from a plane that it is on, at most [unit]; > 0.
};

/// Distance from a plane that a sample is on, at most [unit]: three standard deviations of its
/// errors, and a fifth of a spacing for what sampling and calibration add.
double plane_tolerance(double stddev, double spacing);

/// The indices of the probes on the plane that most of them are on, ascending. Robust: fitted from
/// single probes and their normals.
std::vector<std::size_t> largest_plane(const std::vector<PlaneProbe>& probes);

}  // namespace relief::registration
