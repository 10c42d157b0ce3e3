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

/// A plane through some of the probes, in their frame.
struct PlanarPart {
  std::vector<std::size_t> probes;  ///< Indices of those on it, ascending.
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::UnitZ();
};

/// The plane that most of the probes are on. Robust: fitted from single probes and their normals.
/// Without probes it has none.
PlanarPart largest_plane(const std::vector<PlaneProbe>& probes);

}  // namespace relief::registration
