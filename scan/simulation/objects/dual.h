#pragma once

#include <cmath>

#include <Eigen/Core>

namespace relief::simulation {

/// A number with its gradient in space: forward-mode differentiation of functions of three
/// coordinates, so that a shape is written once and its normals are exact.
struct Dual {
  double value = 0.0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();

  Dual() = default;
  Dual(double constant) : value(constant) {}
  Dual(double v, const Eigen::Vector3d& g) : value(v), gradient(g) {}
};

inline Dual operator-(const Dual& a) { return {-a.value, -a.gradient}; }
inline Dual operator+(const Dual& a, const Dual& b) {
  return {a.value + b.value, a.gradient + b.gradient};
}
inline Dual operator-(const Dual& a, const Dual& b) {
  return {a.value - b.value, a.gradient - b.gradient};
}
inline Dual operator*(const Dual& a, const Dual& b) {
  return {a.value * b.value, a.value * b.gradient + b.value * a.gradient};
}
inline Dual operator/(const Dual& a, const Dual& b) {
  const double quotient = a.value / b.value;
  return {quotient, (a.gradient - quotient * b.gradient) / b.value};
}

inline Dual sqrt(const Dual& a) {
  const double root = std::sqrt(a.value);
  return {root, a.gradient * (0.5 / root)};
}
inline Dual exp(const Dual& a) {
  const double power = std::exp(a.value);
  return {power, power * a.gradient};
}
inline Dual sin(const Dual& a) { return {std::sin(a.value), std::cos(a.value) * a.gradient}; }
inline Dual cos(const Dual& a) { return {std::cos(a.value), -std::sin(a.value) * a.gradient}; }

inline double value_of(double a) { return a; }
inline double value_of(const Dual& a) { return a.value; }

}  // namespace relief::simulation
