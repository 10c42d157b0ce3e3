#include "registration/posegraph/joint/degenerate_views.h"

#include <algorithm>
#include <map>

#include <Eigen/Geometry>

#include "registration/posegraph/pose_step.h"

namespace relief::registration {

namespace {

// Correlation of what all pairs of a view measured along a motion. On a flat board depth cameras
// gave -0.1 to 0.13 within it, where refining moved exact poses by 3 mm. The least of real scans
// of objects and rooms is 0.24 (docs/results.md, Scans that nothing was developed against).
constexpr double kLeastCorrelation = 0.2;

}  // namespace

PairConstraint::PairConstraint(const std::vector<ViewSurface>& surfaces,
                               const std::vector<RigidMotion>& world_from_view, std::size_t first,
                               std::size_t second, const SharedSurface& shared)
    : a(first), b(second) {
  for (const std::size_t view : {a, b}) {
    const ViewSurface& surface = surfaces[view];
    if (!(surface.radius() > 0.0)) return;
    SharedConstraintSum sum(world_from_view[view] * surface.centre(), surface.radius());
    for (std::size_t i = 0; i < shared.points.size(); ++i)
      sum.add(shared.points[i], shared.normals[i]);
    of_views.push_back(sum);
  }
}

MotionsOfViews degenerate_directions_of_views(std::size_t views,
                                              const std::vector<PairConstraint>& pairs) {
  std::map<std::size_t, SharedConstraintSum> sums;
  const auto add = [&](std::size_t view, const SharedConstraintSum& of_pair) {
    const auto [place, is_first] = sums.try_emplace(view, of_pair);
    if (!is_first) place->second.add(of_pair);
  };
  for (const PairConstraint& pair : pairs) {
    if (pair.of_views.size() < 2) continue;
    add(pair.a, pair.of_views[0]);
    add(pair.b, pair.of_views[1]);
  }
  MotionsOfViews motions(views);
  for (const auto& [view, sum] : sums)
    motions[view] = directions_without_shared_relief(sum.constraints(), kLeastCorrelation);
  return motions;
}

RigidMotion without_drift(const ViewSurface& surface, const RigidMotion& start,
                          const RigidMotion& refined,
                          const std::vector<DegenerateDirection>& motions) {
  if (motions.empty()) return refined;
  const Eigen::Vector3d centre = start * surface.centre();
  const Eigen::AngleAxisd turn((refined * start.inverse()).linear());
  RigidTangent moved_by;
  moved_by << turn.angle() * turn.axis(), refined * surface.centre() - centre;
  const double squared_radius = surface.radius() * surface.radius();
  return moved(start, without_motions(motions, centre, squared_radius) * moved_by, centre);
}

}  // namespace relief::registration
