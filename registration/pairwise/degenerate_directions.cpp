#include "registration/pairwise/degenerate_directions.h"

#include <algorithm>
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
class ConstraintRows {
 public:
  explicit ConstraintRows(const std::vector<OrientedPoint>& points) {
    const double count = static_cast<double>(points.size());
    const Eigen::Vector3d first = points.front().point;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& p : points) sum += p.point - first;
    centre_ = first + sum / count;
    double distance = 0.0;
    for (const auto& p : points) distance += (p.point - centre_).norm();
    radius_ = distance / count;
  }

  bool extended() const { return radius_ > 0.0; }
  const Eigen::Vector3d& centre() const { return centre_; }
  double radius() const { return radius_; }

  Vector6d row(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
    Vector6d j;
    j << ((point - centre_) / radius_).cross(normal), normal;
    return j;
  }

 private:
  Eigen::Vector3d centre_;
  double radius_ = 0.0;
};

}  // namespace

ConstraintSpectrum analyse_constraints(const std::vector<OrientedPoint>& points) {
  ConstraintSpectrum result;
  if (points.size() < kFewestPoints) return result;
  const double count = static_cast<double>(points.size());
  const ConstraintRows rows(points);
  result.centre = rows.centre();
  if (!rows.extended()) return result;
  result.radius = rows.radius();
  Matrix6d covariance = Matrix6d::Zero();
  for (const auto& p : points)
    covariance.selfadjointView<Eigen::Lower>().rankUpdate(rows.row(p.point, p.normal));
  const auto eigen = eigen_decomposition(Matrix6d(covariance / count));
  result.eigenvalues = eigen.eigenvalues().cwiseMax(0.0);
  result.directions = eigen.eigenvectors();
  return result;
}

SharedConstraint least_shared_constraint(const std::vector<OrientedPoint>& points,
                                         const std::vector<Eigen::Vector3d>& normals) {
  assert(points.size() == normals.size());
  SharedConstraint result;
  if (points.size() < kFewestPoints) return result;
  const ConstraintRows rows(points);
  if (!rows.extended()) return result;
  Matrix6d shared = Matrix6d::Zero(), own = Matrix6d::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector6d a = rows.row(points[i].point, points[i].normal),
                   b = rows.row(points[i].point, normals[i]);
    shared.selfadjointView<Eigen::Lower>().rankUpdate(a, b, 0.5);
    own.selfadjointView<Eigen::Lower>().rankUpdate(a, 0.5).rankUpdate(b, 0.5);
  }
  const auto eigen = eigen_decomposition(Matrix6d(shared / static_cast<double>(points.size())));
  const Vector6d motion = eigen.eigenvectors().col(0);
  const Vector6d held = own.selfadjointView<Eigen::Lower>() * motion;
  const double of_both = motion.dot(held) / static_cast<double>(points.size());
  result.eigenvalue = eigen.eigenvalues()[0];
  result.correlation = of_both > 0.0 ? result.eigenvalue / of_both : 0.0;
  result.motion << motion.head<3>() / rows.radius(), motion.tail<3>();
  result.centre = rows.centre();
  return result;
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

double eigenvalue_threshold(double normal_noise) {
  return std::max(1e-4, 4.0 * normal_noise * normal_noise);
}

}  // namespace relief::registration
