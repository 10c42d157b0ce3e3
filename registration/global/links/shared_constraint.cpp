#include "registration/global/links/shared_constraint.h"

#include <algorithm>
#include <array>

namespace relief::registration {

namespace {

// Correlations of what holds the two views. At right poses of scanners they are 0.95 and more. Of
// depth cameras they are 0.1 to 0.9: the more noise, the less (docs/results.md, Scans that nothing
// was developed against). Above this there is more relief than
// noise.
constexpr double kMoreRelief = 0.5;

// How far a view is moved [its radii]: beyond what ICP makes up for on relief that is half as long.
constexpr double kMove = 0.15;
// Of that, where it rests. Less is on the way back.
constexpr double kStays = 0.5;
// Overlap and RMS there, of what they were: along a degenerate direction both stay, but for
// borders.
constexpr double kOverlapKept = 0.7, kWorseFit = 1.25;

double mean_displacement(const SharedSurface& shared, const RigidMotion& motion) {
  double sum = 0.0;
  for (const OrientedPoint& p : shared.points) sum += (motion * p.point - p.point).norm();
  return sum / static_cast<double>(shared.points.size());
}

bool fits_as_well(const PoseEvidence& there, const PoseEvidence& here) {
  const bool in_empty_space = violates_free_space(there) &&
                              there.free_space_violation > kWorseFit * here.free_space_violation;
  return !in_empty_space && there.overlap >= kOverlapKept * here.overlap &&
         there.rms <= kWorseFit * here.rms && there.normal_rms <= kWorseFit * here.normal_rms;
}

}  // namespace

bool lacks_shared_constraint(const ViewSurface& a, const ViewSurface& b, const PoseHypothesis& pose,
                             const CoarseScale& scale, const JudgeOptions& judge) {
  const SharedSurface shared = shared_surface(a, b, pose.b_from_a, judge);
  const SharedConstraints held = shared_constraints(shared.points, shared.normals);
  const double correlation = held.correlations[0];
  if (correlation >= kMoreRelief) return false;
  if (correlation < kNoSharedRelief) return true;
  RigidTangent motion = held.spectrum.directions.col(0);
  motion.head<3>() /= held.spectrum.radius;  // Points move by one unit, about.
  const RigidMotion to_centre(Eigen::Translation3d(held.spectrum.centre));
  const double distance = kMove * std::min(a.radius(), b.radius());
  return std::ranges::any_of(std::array{-distance, distance}, [&](double by) {
    const RigidMotion moved = to_centre * motion_from_tangent(by * motion) * to_centre.inverse();
    const PoseHypothesis there =
        refine_hypothesis(a, b, moved * pose.b_from_a, refinement_reach(scale), judge);
    const double rests = mean_displacement(shared, there.b_from_a * pose.b_from_a.inverse());
    return rests > kStays * mean_displacement(shared, moved) &&
           fits_as_well(there.evidence, pose.evidence);
  });
}

}  // namespace relief::registration
