#pragma once

#include <cstddef>
#include <span>
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

/// In ascending order of the eigenvalues.
ConstraintSpectrum sorted(const ConstraintSpectrum& spectrum);

/// All eigenvalues are zero for fewer than six points.
ConstraintSpectrum analyse_constraints(std::span<const OrientedPoint> points);

/// How firmly two surfaces that lie on each other are held by what both show.
///
/// Noise of normals holds surfaces as relief does: it adds to the eigenvalues of either surface
/// alone. The normals of two measurements share relief and no noise, so the mean of
/// (j_a j_b^T + j_b j_a^T) / 2, with j of (R5), has none on average.
struct SharedConstraints {
  /// Of that mean; negative eigenvalues are chance.
  ConstraintSpectrum spectrum;
  /// The eigenvalues as fractions of the mean of both surfaces' own in the same directions: 1 where
  /// both show the same, 0 where what each shows is its own, as noise or another feature.
  Vector6d correlations = Vector6d::Zero();
};

/// How firmly surfaces are held along one motion: sums of squared displacements along the normals
/// [unit^2].
struct MotionConstraint {
  double shared = 0.0;  ///< By what both show: see SharedConstraints.
  double own = 0.0;     ///< Mean of what each shows by itself, noise included.

  /// Zero where nothing holds them.
  double correlation() const { return own > 0.0 ? shared / own : 0.0; }
};

/// Sums up points of the surfaces, for SharedConstraints about a centre.
class SharedConstraintSum {
 public:
  SharedConstraintSum() = default;
  /// `radius` [unit], > 0: see ConstraintSpectrum.
  SharedConstraintSum(const Eigen::Vector3d& centre, double radius)
      : centre_(centre), radius_(radius) {}

  /// A point of either surface, and the unit normal of the other one there.
  void add(const OrientedPoint& point, const Eigen::Vector3d& normal);
  /// What another sum about the same centre holds.
  void add(const SharedConstraintSum& other);
  /// The same sum about another centre.
  SharedConstraintSum about(const Eigen::Vector3d& centre, double radius) const;
  /// Zero for fewer than six points.
  SharedConstraints constraints() const;
  /// Along a motion in the frame of the points.
  MotionConstraint along(const DegenerateDirection& motion) const;

 private:
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double radius_ = 1.0;
  Matrix6d shared_ = Matrix6d::Zero(), own_ = Matrix6d::Zero();  // Their lower halves.
  std::size_t count_ = 0;
};

/// The same for points that are all there, about their mean.
SharedConstraints shared_constraints(const std::vector<OrientedPoint>& points,
                                     const std::vector<Eigen::Vector3d>& normals);

/// Correlations of two views below this are no more than chance makes of a thousand samples.
inline constexpr double kNoSharedRelief = 0.1;

/// The motions whose correlations are below `least_correlation`.
std::vector<DegenerateDirection> directions_without_shared_relief(
    const SharedConstraints& held, double least_correlation = kNoSharedRelief);

/// The directions whose eigenvalue is below `threshold`. Within their span the basis is chosen so
/// that pure translations come first.
std::vector<DegenerateDirection> degenerate_directions(const ConstraintSpectrum& spectrum,
                                                       double threshold);

/// The motion of a degenerate direction, which is about its own centre, as a tangent about another.
RigidTangent tangent_about(const Eigen::Vector3d& centre, const DegenerateDirection& direction);

/// For each view, some of its motions; world frame.
using MotionsOfViews = std::vector<std::vector<DegenerateDirection>>;

/// Takes the part along `motions` out of tangents about `centre`. A turn by one radian counts for
/// as much as a translation by the lever [unit], which is given squared.
Matrix6d without_motions(const std::vector<DegenerateDirection>& motions,
                         const Eigen::Vector3d& centre, double squared_lever);

/// The eigenvalue that noise of the normals [rad] alone produces, with a factor of two in the
/// angle: a direction below it is degenerate. At least (0.6 deg)^2.
double eigenvalue_threshold(double normal_noise);

}  // namespace relief::registration
