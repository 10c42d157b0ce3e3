#include "registration/pairwise/plane_step.h"

#include <cmath>

#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "registration/pairwise/normal_equations.h"
#include "registration/pairwise/robust.h"
#include "scan/base/linear_algebra.h"
#include "scan/base/robust_scales.h"

namespace relief::registration {

namespace {

// Tangents scaled so that rotations and translations weigh alike: translation in radii.
NormalEquations linearise(const std::vector<PlanePair>& pairs, IcpObjective objective,
                          const ConstraintSpectrum& about) {
  NormalEquations system;
  for (const auto& pair : pairs) {
    const Eigen::Vector3d p = (pair.moving - about.centre) / about.radius;
    const Eigen::Vector3d q = (pair.fixed - about.centre) / about.radius;
    Vector6d j;
    if (objective == IcpObjective::kPointToPlane) {
      // (R1): n . (p + w x p + v - q).
      j << p.cross(pair.normal), pair.normal;
      system.add(j, pair.normal.dot(p - q), pair.weight);
    } else {
      // (R2), Rusinkiewicz 2019, eq. 10: n . (p - q) + ((p + q) x n) . a + n . t, here with the
      // mean instead of the sum of the normals.
      const Eigen::Vector3d n = 0.5 * (pair.moving_normal + pair.fixed_normal);
      j << (p + q).cross(n), n;
      system.add(j, n.dot(p - q), pair.weight);
    }
  }
  return system;
}

// Which of the two views' gradients the products of derivatives are made of.
enum class Gradients {
  kMean,    // Of both: positive semidefinite, but noise adds to it.
  kCommon,  // One by the other: what they agree on.
};

// The terms (R7), in radii of the surface like those of planes.
NormalEquations linearise(const NormalTerms& normals, const ConstraintSpectrum& about,
                          const Vector6d& per_parameter, Gradients gradients) {
  NormalEquations system;
  const double unit = normals.length_per_angle / about.radius;
  Vector6d scale = unit * per_parameter;
  scale.tail<3>() *= about.radius;
  for (const NormalMatch& match : normals.matches.items) {
    for (int k = 0; k < 2; ++k) {
      const auto row = [&](const auto& gradient) -> Vector6d {
        return scale.cwiseProduct(match.derivative(k, gradient, about.centre));
      };
      const double weight =
          match.weight * cauchy_weight(match.residual[k] / normals.matches.sigma, kCauchyScale);
      const Vector6d j = row(match.gradient());
      system.gradient += weight * unit * match.residual[k] * j;
      if (gradients == Gradients::kMean) {
        system.matrix.noalias() += weight * j * j.transpose();
      } else {
        const Vector6d s = row(match.source_gradient), t = row(match.target_gradient);
        system.matrix.noalias() += 0.5 * weight * (s * t.transpose() + t * s.transpose());
      }
    }
  }
  return system;
}

// The minimiser within the space that the surface determines, by the first of the two matrices if
// it is positive definite there.
Vector6d solve_within(const Matrix6d& matrix, const Matrix6d& safe, const Vector6d& gradient,
                      const ConstraintSpectrum& spectrum, double threshold) {
  const auto free = static_cast<Eigen::Index>((spectrum.eigenvalues.array() >= threshold).count());
  if (free == 0) return Vector6d::Zero();
  const auto basis = spectrum.directions.rightCols(free);
  const Eigen::VectorXd reduced = basis.transpose() * gradient;
  if (const auto x = solve_positive_definite(basis.transpose() * matrix * basis, reduced))
    return -(basis * *x);
  return -(basis * solve_symmetric(basis.transpose() * safe * basis, reduced));
}

RigidMotion about(const Eigen::Vector3d& centre, const RigidMotion& motion) {
  return Eigen::Translation3d(centre) * motion * Eigen::Translation3d(-centre);
}

RigidMotion motion_of(const Vector6d& x, IcpObjective objective, double radius) {
  if (objective == IcpObjective::kPointToPlane) {
    RigidTangent tangent = x;
    tangent.tail<3>() *= radius;
    return motion_from_tangent(tangent);
  }
  // Half the rotation is applied before and half after the translation (Rusinkiewicz 2019, sec. 4).
  const Eigen::Vector3d a = x.head<3>();
  const double angle = std::atan(a.norm());
  RigidMotion half = RigidMotion::Identity();
  if (angle > 0.0) half.linear() = Eigen::AngleAxisd(angle, a.normalized()).toRotationMatrix();
  const Eigen::Vector3d translation = radius * std::cos(angle) * x.tail<3>();
  return half * Eigen::Translation3d(translation) * half;
}

}  // namespace

ConstraintSpectrum analyse_constraints(const std::vector<PlanePair>& pairs) {
  std::vector<OrientedPoint> points;
  points.reserve(pairs.size());
  for (const auto& pair : pairs) points.push_back({pair.fixed, pair.normal});
  return analyse_constraints(points);
}

PlaneStep solve_plane_step(const std::vector<PlanePair>& pairs, const NormalTerms& normals,
                           IcpObjective objective, double threshold) {
  PlaneStep step;
  step.spectrum = with_normal_maps(analyse_constraints(pairs), normals.matches,
                                   normals.length_per_angle, threshold);
  // The symmetric objective's first parameter is half the rotation.
  Vector6d per_parameter = Vector6d::Ones();
  if (objective == IcpObjective::kSymmetric) per_parameter.head<3>() *= 2.0;
  const auto planes = linearise(pairs, objective, step.spectrum);
  const auto mean = linearise(normals, step.spectrum, per_parameter, Gradients::kMean);
  const auto common = linearise(normals, step.spectrum, per_parameter, Gradients::kCommon);
  const Vector6d x = solve_within(planes.matrix + common.matrix, planes.matrix + mean.matrix,
                                  planes.gradient + mean.gradient, step.spectrum, threshold);
  step.motion = about(step.spectrum.centre, motion_of(x, objective, step.spectrum.radius));
  return step;
}

}  // namespace relief::registration
