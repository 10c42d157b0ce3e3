#include "registration/pairwise/degenerate_directions.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>

#include <Eigen/Core>

#include "scan/base/linear_algebra.h"

namespace relief::registration {

namespace {

std::string format(const Eigen::Vector3d& v) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.3g %.3g %.3g)", v.x(), v.y(), v.z());
  return text;
}

// A rotation w with translation v at `centre` is a screw about the axis through
// centre + w x v / |w|^2 (Chasles).
std::string describe(const RigidTangent& motion, const Eigen::Vector3d& centre, double radius) {
  const Eigen::Vector3d rotation = motion.head<3>(), translation = motion.tail<3>();
  if (rotation.norm() * radius < 0.1 * translation.norm())
    return "sliding along " + format(translation.normalized());
  const double square = rotation.squaredNorm();
  const Eigen::Vector3d axis_point = centre + rotation.cross(translation) / square;
  const double pitch = rotation.dot(translation) / square;
  std::string text =
      "turning about " + format(rotation.normalized()) + " through " + format(axis_point);
  if (std::abs(pitch) > 0.1 * radius) text += " while sliding along it";
  return text;
}

constexpr std::size_t kFewestPoints = 6;

// (R5): j = (x n, n), with x about a centre and scaled to mean length 1.
Vector6d constraint_row(const OrientedPoint& p, const Eigen::Vector3d& centre, double radius) {
  Vector6d j;
  j << ((p.point - centre) / radius).cross(p.normal), p.normal;
  return j;
}

// The mean of the points, and their mean distance from it.
struct Extent {
  Eigen::Vector3d centre;
  double radius = 0.0;

  explicit Extent(std::span<const OrientedPoint> points) {
    const double count = static_cast<double>(points.size());
    const Eigen::Vector3d first = points.front().point;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& p : points) sum += p.point - first;
    centre = first + sum / count;
    double distance = 0.0;
    for (const auto& p : points) distance += (p.point - centre).norm();
    radius = distance / count;
  }
};

}  // namespace

ConstraintSpectrum sorted(const ConstraintSpectrum& spectrum) {
  std::array<Eigen::Index, 6> order{0, 1, 2, 3, 4, 5};
  std::ranges::stable_sort(order, {}, [&](Eigen::Index k) { return spectrum.eigenvalues[k]; });
  ConstraintSpectrum result = spectrum;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const Eigen::Index from = order[static_cast<std::size_t>(k)];
    result.eigenvalues[k] = spectrum.eigenvalues[from];
    result.directions.col(k) = spectrum.directions.col(from);
  }
  return result;
}

ConstraintSpectrum analyse_constraints(std::span<const OrientedPoint> points) {
  ConstraintSpectrum result;
  if (points.size() < kFewestPoints) return result;
  const double count = static_cast<double>(points.size());
  const Extent extent(points);
  result.centre = extent.centre;
  if (!(extent.radius > 0.0)) return result;
  result.radius = extent.radius;
  Matrix6d covariance = Matrix6d::Zero();
  for (const auto& p : points)
    covariance.selfadjointView<Eigen::Lower>().rankUpdate(
        constraint_row(p, result.centre, result.radius));
  const auto eigen = eigen_decomposition(Matrix6d(covariance / count));
  result.eigenvalues = eigen.eigenvalues().cwiseMax(0.0);
  result.directions = eigen.eigenvectors();
  return result;
}

void SharedConstraintSum::add(const OrientedPoint& point, const Eigen::Vector3d& normal) {
  const Vector6d a = constraint_row(point, centre_, radius_),
                 b = constraint_row({point.point, normal}, centre_, radius_);
  shared_.selfadjointView<Eigen::Lower>().rankUpdate(a, b, 0.5);
  own_.selfadjointView<Eigen::Lower>().rankUpdate(a, 0.5).rankUpdate(b, 0.5);
  ++count_;
}

void SharedConstraintSum::add(const SharedConstraintSum& other) {
  shared_ += other.shared_;
  own_ += other.own_;
  count_ += other.count_;
}

SharedConstraintSum SharedConstraintSum::about(const Eigen::Vector3d& centre, double radius) const {
  // (x - c') / r' x n = (r / r') ((x - c) / r x n) - (c' - c) / r' x n.
  Matrix6d change = Matrix6d::Identity();
  change.topLeftCorner<3, 3>() *= radius_ / radius;
  const Eigen::Vector3d d = (centre - centre_) / radius;
  change.topRightCorner<3, 3>() << 0.0, d.z(), -d.y(), -d.z(), 0.0, d.x(), d.y(), -d.x(), 0.0;
  const auto transformed = [&](const Matrix6d& lower) -> Matrix6d {
    return change * lower.selfadjointView<Eigen::Lower>() * change.transpose();
  };
  SharedConstraintSum sum(centre, radius);
  sum.shared_ = transformed(shared_);
  sum.own_ = transformed(own_);
  sum.count_ = count_;
  return sum;
}

SharedConstraints SharedConstraintSum::constraints() const {
  SharedConstraints result;
  result.spectrum.centre = centre_;
  result.spectrum.radius = radius_;
  if (count_ < kFewestPoints) return result;
  const auto eigen = eigen_decomposition(Matrix6d(shared_ / static_cast<double>(count_)));
  result.spectrum.eigenvalues = eigen.eigenvalues();
  result.spectrum.directions = eigen.eigenvectors();
  for (Eigen::Index k = 0; k < 6; ++k) {
    const Vector6d direction = result.spectrum.directions.col(k);
    const Vector6d held = own_.selfadjointView<Eigen::Lower>() * direction;
    const double own = direction.dot(held) / static_cast<double>(count_);
    if (own > 0.0) result.correlations[k] = result.spectrum.eigenvalues[k] / own;
  }
  return result;
}

MotionConstraint SharedConstraintSum::along(const DegenerateDirection& motion) const {
  RigidTangent tangent = tangent_about(centre_, motion);
  tangent.head<3>() *= radius_;
  const auto held = [&](const Matrix6d& lower) {
    const Vector6d by = lower.selfadjointView<Eigen::Lower>() * tangent;
    return tangent.dot(by);
  };
  return {held(shared_), held(own_)};
}

SharedConstraints shared_constraints(const std::vector<OrientedPoint>& points,
                                     const std::vector<Eigen::Vector3d>& normals) {
  assert(points.size() == normals.size());
  if (points.size() < kFewestPoints) return {};
  const Extent extent(points);
  if (!(extent.radius > 0.0)) return {};
  SharedConstraintSum sum(extent.centre, extent.radius);
  for (std::size_t i = 0; i < points.size(); ++i) sum.add(points[i], normals[i]);
  return sum.constraints();
}

std::vector<DegenerateDirection> directions_without_shared_relief(const SharedConstraints& held,
                                                                  double least_correlation) {
  ConstraintSpectrum by_correlation = held.spectrum;
  by_correlation.eigenvalues = held.correlations;
  return degenerate_directions(sorted(by_correlation), least_correlation);
}

std::vector<DegenerateDirection> degenerate_directions(const ConstraintSpectrum& spectrum,
                                                       double threshold) {
  const auto count = (spectrum.eigenvalues.array() < threshold).count();
  if (count == 0) return {};
  // Within the degenerate space any basis is as good; the singular vectors of its rotational part
  // separate the pure translations (singular value 0, first) from the rest.
  const Eigen::MatrixXd space = spectrum.directions.leftCols(count), rotations = space.topRows(3);
  const auto singular = eigen_decomposition(Eigen::MatrixXd(rotations.transpose() * rotations));
  const Eigen::MatrixXd basis = space * singular.eigenvectors();
  std::vector<DegenerateDirection> result;
  for (Eigen::Index k = 0; k < count; ++k) {
    DegenerateDirection direction;
    direction.centre = spectrum.centre;
    direction.motion << basis.col(k).head<3>(), spectrum.radius * basis.col(k).tail<3>();
    direction.description = describe(direction.motion, spectrum.centre, spectrum.radius);
    result.push_back(std::move(direction));
  }
  return result;
}

RigidTangent tangent_about(const Eigen::Vector3d& centre, const DegenerateDirection& direction) {
  const Eigen::Vector3d turn = direction.motion.head<3>();
  RigidTangent about;
  about << turn, direction.motion.tail<3>() + turn.cross(centre - direction.centre);
  return about;
}

Matrix6d without_motions(const std::vector<DegenerateDirection>& motions,
                         const Eigen::Vector3d& centre, double squared_lever) {
  if (motions.empty()) return Matrix6d::Identity();
  Vector6d weight = Vector6d::Ones();
  weight.head<3>().setConstant(squared_lever);
  Eigen::MatrixXd left_out(6, motions.size());
  for (std::size_t k = 0; k < motions.size(); ++k)
    left_out.col(static_cast<Eigen::Index>(k)) = tangent_about(centre, motions[k]);
  const Eigen::MatrixXd weighted = weight.asDiagonal() * left_out;
  return Matrix6d::Identity() - left_out * solve_symmetric(left_out.transpose() * weighted,
                                                           Eigen::MatrixXd(weighted.transpose()));
}

double eigenvalue_threshold(double normal_noise) {
  return std::max(1e-4, 4.0 * normal_noise * normal_noise);
}

}  // namespace relief::registration
