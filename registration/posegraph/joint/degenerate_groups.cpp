#include "registration/posegraph/joint/degenerate_groups.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "registration/posegraph/pose_step.h"

namespace relief::registration {

namespace {

// Correlation of what all pairs of a group with the rest measured along a motion. On a flat board
// depth cameras gave -0.1 to 0.13 within it, where refining moved exact poses by 3 mm; in a room
// with blurred depths -0.01 to 0.08, where eight views moved by 0.4 m together. The least of real
// scans of objects and rooms is 0.24 (docs/results.md, Scans that nothing was developed against).
constexpr double kLeastCorrelation = 0.2;

// A motion of which less than this fraction is not along others counts as one of them: walls that
// are not quite parallel give motions a few degrees apart.
constexpr double kNewMotion = 0.5;

// The other views that a cluster is linked to.
std::vector<std::size_t> complement(const std::vector<std::size_t>& views,
                                    const std::vector<std::size_t>& linked) {
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < linked.size(); ++i)
    if (linked[i] == linked[views.front()] && !std::ranges::binary_search(views, i))
      others.push_back(i);
  return others;
}

// What the views moved by on average since the start, as a tangent about a centre.
RigidTangent mean_motion(const std::vector<std::size_t>& views,
                         const std::vector<RigidMotion>& start,
                         const std::vector<RigidMotion>& world_from_view,
                         const Eigen::Vector3d& centre) {
  RigidTangent sum = RigidTangent::Zero();
  for (const std::size_t i : views)
    sum += tangent_at(world_from_view[i] * start[i].inverse(), centre);
  return views.empty() ? sum : RigidTangent(sum / static_cast<double>(views.size()));
}

void move_back(const std::vector<std::size_t>& views, const RigidTangent& tangent,
               const Eigen::Vector3d& centre, std::vector<RigidMotion>& world_from_view) {
  const RigidMotion back = moved(RigidMotion::Identity(), tangent, centre).inverse();
  for (const std::size_t i : views) world_from_view[i] = back * world_from_view[i];
}

// The product of two tangents about one centre in the metric in which a turn by one radian counts
// for as much as a translation by the radius.
double product(const RigidTangent& a, const RigidTangent& b, double radius) {
  return radius * radius * a.head<3>().dot(b.head<3>()) + a.tail<3>().dot(b.tail<3>());
}

// Whether a motion of a view is not mostly along others of it.
bool is_new(const DegenerateDirection& motion, const std::vector<DegenerateDirection>& others,
            const ViewSurface& surface, const RigidMotion& world_from_view) {
  const Eigen::Vector3d centre = world_from_view * surface.centre();
  const double radius = surface.radius();
  const RigidTangent whole = tangent_about(centre, motion);
  const RigidTangent rest = without_motions(others, centre, radius * radius) * whole;
  return product(rest, rest, radius) > kNewMotion * kNewMotion * product(whole, whole, radius);
}

}  // namespace

std::vector<DegenerateGroup> degenerate_groups(const std::vector<PairConstraint>& pairs,
                                               const std::vector<ViewSurface>& surfaces,
                                               const std::vector<RigidMotion>& world_from_view,
                                               const std::vector<std::size_t>& linked,
                                               const std::vector<bool>& held) {
  const auto moves = [&](const std::vector<std::size_t>& views) {
    return std::ranges::none_of(views, [&](std::size_t i) { return held[i]; });
  };
  std::vector<DegenerateGroup> groups;
  for (ViewCluster& cluster : cluster_views(surfaces, world_from_view, pairs)) {
    auto views =
        moves(cluster.views) ? std::move(cluster.views) : complement(cluster.views, linked);
    if (!moves(views)) continue;
    const ViewsExtent extent(views, surfaces, world_from_view);
    auto motions = directions_without_shared_relief(
        cluster.with_others.about(extent.centre, extent.radius).constraints(), kLeastCorrelation);
    if (!motions.empty()) groups.push_back({std::move(views), std::move(motions)});
  }
  std::ranges::sort(groups, [](const DegenerateGroup& a, const DegenerateGroup& b) {
    return a.views.size() != b.views.size() ? a.views.size() < b.views.size() : a.views < b.views;
  });
  // The last two clusters are each other's complement.
  const auto same_views = [](const auto& a, const auto& b) { return a.views == b.views; };
  groups.erase(std::unique(groups.begin(), groups.end(), same_views), groups.end());
  return groups;
}

MotionConstraint constraint_along_motions(const std::vector<DegenerateGroup>& groups,
                                          const std::vector<PairConstraint>& pairs) {
  MotionConstraint sum;
  for (const auto& [views, motions] : groups) {
    const auto inside = [&](std::size_t i) { return std::ranges::binary_search(views, i); };
    for (const PairConstraint& pair : pairs) {
      if (inside(pair.a) == inside(pair.b)) continue;
      for (const DegenerateDirection& motion : motions) {
        const MotionConstraint along = pair.shared.along(motion);
        sum.shared += along.shared;
        sum.own += along.own;
      }
    }
  }
  return sum;
}

MotionsOfViews remove_drift(const std::vector<DegenerateGroup>& groups, Drift drift,
                            const std::vector<ViewSurface>& surfaces,
                            const std::vector<RigidMotion>& start,
                            std::vector<RigidMotion>& world_from_view) {
  MotionsOfViews kept(surfaces.size());
  for (const auto& [views, motions] : groups) {
    const auto [centre, radius] = ViewsExtent(views, surfaces, start);
    if (drift == Drift::kAll) {
      auto own = views;
      std::erase_if(own, [&](std::size_t i) { return !kept[i].empty(); });
      move_back(own, mean_motion(own, start, world_from_view, centre), centre, world_from_view);
    }
    for (const DegenerateDirection& motion : motions) {
      auto own = views;
      std::erase_if(own, [&](std::size_t i) {
        return !is_new(motion, kept[i], surfaces[i], world_from_view[i]);
      });
      const RigidTangent along = tangent_about(centre, motion);
      const RigidTangent moved_by = mean_motion(own, start, world_from_view, centre);
      const double part = product(along, moved_by, radius) / product(along, along, radius);
      move_back(own, part * along, centre, world_from_view);
      for (const std::size_t i : own) kept[i].push_back(motion);
    }
  }
  return kept;
}

}  // namespace relief::registration
