#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace relief::evaluation {

inline double degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

/// The angle between two vectors of any lengths [degrees], accurate at every angle.
template <typename Vector>
double angle_between_deg(const Vector& a, const Vector& b) {
  const Eigen::Vector3d x = a.template cast<double>(), y = b.template cast<double>();
  return degrees(std::atan2(x.cross(y).norm(), x.dot(y)));
}

}  // namespace relief::evaluation
