#include "registration/posegraph/loops/loop_closure.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "registration/posegraph/loops/view_cycles.h"
#include "registration/posegraph/pose_step.h"

namespace relief::registration {

namespace {

using MotionOf = std::map<std::pair<std::size_t, std::size_t>, const PairMotion*>;

// What the scatter of n patches, to which a pair's six parameters were fitted, falls short by; at
// most 2, as for poses.
double degrees_of_freedom(std::size_t patches) {
  const auto count = static_cast<double>(patches);
  return count > 12.0 ? count / (count - 6.0) : 2.0;
}

// Mean square of w x p + t over the points p of a sphere about the centre of the tangent (w, t).
double mean_square(double rotation_square, double translation_square, double radius) {
  return translation_square + 2.0 / 3.0 * radius * radius * rotation_square;
}

// The walk around one cycle.
class Walk {
 public:
  explicit Walk(double variance_inflation) : inflation_(variance_inflation) {}

  // From the pair's first view to its second, or back.
  void pass(const PairMotion& pair, bool forward) {
    const double sign = forward ? 1.0 : -1.0;
    around_ = motion_from_tangent(sign * pair.motion) * around_;
    independent_ += pair.independent;
    factor_ = std::max(factor_, degrees_of_freedom(pair.influence.size()));
    // A patch that two pairs of the cycle see counts once: the noise of their common view cancels.
    for (const PatchScore& patch : pair.influence)
      influence_.try_emplace(patch.patch, RigidTangent::Zero()).first->second += sign * patch.score;
  }

  const RigidMotion& around() const { return around_; }

  Matrix6d covariance() const {
    Matrix6d sum = Matrix6d::Zero();
    for (const auto& [patch, moved] : influence_) sum += moved * moved.transpose();
    return inflation_ * factor_ * sum + independent_;
  }

 private:
  double inflation_, factor_ = 1.0;
  RigidMotion around_ = RigidMotion::Identity();
  Matrix6d independent_ = Matrix6d::Zero();
  std::map<std::uint64_t, RigidTangent> influence_;
};

// `offset`: of the cycle's centre from that of the tangents.
void measure(const Walk& walk, const Eigen::Vector3d& offset, LoopClosure& loop) {
  loop.angle = rotation_angle(walk.around());
  const double moved = (walk.around() * offset - offset).squaredNorm();
  loop.length = std::sqrt(mean_square(loop.angle * loop.angle, moved, loop.radius));
  const Matrix6d change = tangents_about(offset);
  const Vector6d variance = (change * walk.covariance() * change.transpose()).diagonal();
  const double rotation = std::max(0.0, variance.head<3>().sum());
  loop.angle_std = std::sqrt(rotation);
  loop.length_std =
      std::sqrt(mean_square(rotation, std::max(0.0, variance.tail<3>().sum()), loop.radius));
}

LoopClosure close_loop(const std::vector<std::size_t>& cycle, const std::vector<PlacedView>& views,
                       const MotionOf& motion_of, const Eigen::Vector3d& centre,
                       double variance_inflation) {
  LoopClosure loop;
  loop.views = cycle;
  Walk walk(variance_inflation);
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  const double share = 1.0 / static_cast<double>(cycle.size());
  for (std::size_t i = 0; i < cycle.size(); ++i) {
    const std::size_t from = cycle[i], to = cycle[(i + 1) % cycle.size()];
    walk.pass(*motion_of.at(std::minmax(from, to)), from < to);
    offset += share * (views[from].centre - centre);
    loop.radius += share * views[from].radius;
  }
  measure(walk, offset, loop);
  return loop;
}

}  // namespace

std::vector<LoopClosure> close_loops(const std::vector<PlacedView>& views,
                                     const std::vector<PairMotion>& motions,
                                     const std::vector<PairFit>& overlaps,
                                     const Eigen::Vector3d& centre, double variance_inflation) {
  MotionOf motion_of;
  for (const PairMotion& motion : motions) motion_of[{motion.a, motion.b}] = &motion;
  std::vector<ViewPair> pairs;
  for (const PairFit& fit : overlaps)
    if (motion_of.contains({fit.a, fit.b})) pairs.push_back({fit.a, fit.b, fit.overlap});
  std::vector<LoopClosure> loops;
  for (const auto& cycle : smallest_cycles(views.size(), pairs))
    loops.push_back(close_loop(cycle, views, motion_of, centre, variance_inflation));
  std::stable_sort(loops.begin(), loops.end(),
                   [](const auto& a, const auto& b) { return a.ratio() > b.ratio(); });
  return loops;
}

std::vector<LoopClosure> loop_closures(const std::vector<ViewSurface>& surfaces,
                                       const std::vector<RigidMotion>& world_from_view,
                                       const PoseGraphLastStep& last,
                                       const std::vector<PairFit>& fits) {
  std::vector<PlacedView> views;
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    views.push_back({world_from_view[i] * surfaces[i].centre(), surfaces[i].radius()});
  return close_loops(views, motions_of_pairs(last, fits), fits, last.centre,
                     last.variance_inflation);
}

}  // namespace relief::registration
