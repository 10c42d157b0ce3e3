#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "relief/registration/pair_fit.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// A point of a surface and its unit normal, any frame.
struct OrientedPoint {
  Eigen::Vector3d point, normal;
};

/// The eigenvalues of the constraint matrix of point-to-plane alignment: how firmly a set of
/// surface points determines a rigid motion (Gelfand et al. 2003), equation (R5). Tangents are
/// (rotation [rad], translation / radius) about `centre`.
struct ConstraintSpectrum {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 1.0;  ///< Mean distance of the points from the centre [unit].
  /// Mean squared displacement along the normals, in radii, per unit motion; ascending order.
  Vector6d eigenvalues = Vector6d::Zero();
  Matrix6d directions = Matrix6d::Identity();  ///< Columns belong to `eigenvalues`.
};

/// All eigenvalues are zero for fewer than six points.
ConstraintSpectrum analyse_constraints(const std::vector<OrientedPoint>& points);

/// Of two surfaces that lie on each other, the motion that holds them least by what both show.
///
/// Noise of normals holds surfaces as relief does: it adds to the eigenvalues of either surface
/// alone. The normals of two measurements share relief and no noise, so the mean of
/// (j_a j_b^T + j_b j_a^T) / 2, with j of (R5), has none on average.
struct SharedConstraint {
  double eigenvalue = 0.0;  ///< The least one of that mean; negative ones are chance.
  /// The same as a fraction of the mean of both surfaces' own, in the direction of that motion: 1
  /// where both show the same, 0 where what each shows is its own, as noise or another feature.
  double correlation = 0.0;
  /// The motion: rotation [rad] and translation [unit] at `centre`, by which points move by one
  /// unit, about.
  RigidTangent motion = RigidTangent::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

/// `normals` are those of the other surface at `points`. Zero for fewer than six points.
SharedConstraint least_shared_constraint(const std::vector<OrientedPoint>& points,
                                         const std::vector<Eigen::Vector3d>& normals);

/// The directions whose eigenvalue is below `threshold`. Within their span the basis is chosen so
/// that pure translations come first.
std::vector<DegenerateDirection> degenerate_directions(const ConstraintSpectrum& spectrum,
                                                       double threshold);

/// The motion of a degenerate direction, which is about its own centre, as a tangent about another.
RigidTangent tangent_about(const Eigen::Vector3d& centre, const DegenerateDirection& direction);

/// The eigenvalue that noise of the normals [rad] alone produces, with a factor of two in the
/// angle: a direction below it is degenerate. At least (0.6 deg)^2.
double eigenvalue_threshold(double normal_noise);

}  // namespace relief::registration
