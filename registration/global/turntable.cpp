#include "registration/global/turntable.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "registration/global/links/link_limits.h"
#include "registration/global/pair_search.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
// Of ICP [radii of a view]: turns are at most 30 degrees apart, and 15 move the rim by 0.26.
constexpr double kSearchRadii = 0.3;
// Of poses that turns give [radii of a view]: half of that. Only ranks them.
constexpr double kReachRadii = 0.15;
constexpr std::size_t kRefined = 16;  // Of 61 turns; bounds the time.

// The object turned by `angle` about an axis in the sensor's vertical plane, `tilt` off the y axis,
// through a point behind the mean of the two visible surfaces.
RigidMotion turn(const ViewSurface& reference, const ViewSurface& view, double angle, double tilt) {
  const Eigen::Vector3d axis(0.0, std::cos(tilt), std::sin(tilt));
  const auto middle = [](const ViewSurface& surface) {
    const Eigen::Vector3d towards_sensor = surface.mean_normal();
    return Eigen::Vector3d(surface.centre() - 0.5 * surface.radius() * towards_sensor);
  };
  const Eigen::Vector3d centre = 0.5 * (middle(reference) + middle(view));
  return Eigen::Translation3d(centre) * Eigen::AngleAxisd(angle, axis) *
         Eigen::Translation3d(-centre);
}

std::vector<RigidMotion> turns(const ViewSurface& reference, const ViewSurface& view,
                               std::size_t views) {
  std::vector<RigidMotion> list = {RigidMotion::Identity()};
  for (const double angle : {360.0 / static_cast<double>(views), 15.0, 30.0, 45.0, 60.0, 90.0})
    for (const double tilt : {0.0, -20.0, 20.0, -40.0, 40.0})
      for (const double sign : {1.0, -1.0})
        list.push_back(
            turn(reference, view, sign * angle * kRadiansPerDegree, tilt * kRadiansPerDegree));
  return list;
}

// The motion from view `a` to the one that follows it in the order of the scan, if both are in one
// group.
std::optional<RigidMotion> known_step(const ViewGroups& groups, std::size_t a) {
  const std::size_t next = (a + 1) % groups.group.size();
  if (groups.group[a] != groups.group[next]) return std::nullopt;
  return groups.group_from_view[next].inverse() * groups.group_from_view[a];
}

// The known steps nearest to view `a`, one after it and one before.
std::vector<RigidMotion> steps_about(const ViewGroups& groups, std::size_t a) {
  std::vector<RigidMotion> steps;
  const std::size_t count = groups.group.size();
  for (const std::size_t direction : {std::size_t{1}, count - 1}) {
    for (std::size_t k = 1; k < count; ++k) {
      const auto step = known_step(groups, (a + k * direction) % count);
      if (!step) continue;
      steps.push_back(*step);
      break;
    }
  }
  return steps;
}

// Those that fit best as they are.
void keep_promising(const ViewSurface& view, const ViewSurface& reference,
                    std::vector<RigidMotion>& starts) {
  const double reach = kReachRadii * std::min(view.radius(), reference.radius());
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < starts.size(); ++k)
    order.emplace_back(-rough_agreement(view, reference, starts[k], reach, kRoughProbes), k);
  std::sort(order.begin(), order.end());
  std::vector<RigidMotion> kept;
  for (std::size_t k = 0; k < std::min(kRefined, order.size()); ++k)
    kept.push_back(starts[order[k].second]);
  starts = std::move(kept);
}

// The search for links between views that follow each other in the order of the scan.
class TurntableSearch {
 public:
  TurntableSearch(const std::vector<ViewSurface>& surfaces, const ViewGroups& groups,
                  const VerificationThresholds& limits, const JudgeOptions& judge)
      : surfaces_(surfaces),
        groups_(groups),
        limits_(limits),
        judge_(judge),
        steps_(surfaces.size()) {}

  std::vector<PoseLink> links() {
    const std::size_t count = surfaces_.size();
    for (std::size_t a = 0; a < count; ++a)
      if (a + 1 < count || count > 2) link_to_next(a);  // The first view follows the last.
    // Doubtful links count only in loops of three.
    for (std::size_t a = 0; a < count; ++a)
      if (count > 3) link_over_next(a);
    return std::move(links_);
  }

 private:
  // Whether both views have samples and are not in one group yet.
  bool apart(std::size_t a, std::size_t b) const {
    return groups_.group[a] != groups_.group[b] && !surfaces_[a].samples().empty() &&
           !surfaces_[b].samples().empty();
  }

  void link_to_next(std::size_t a) {
    const std::size_t count = surfaces_.size(), b = (a + 1) % count;
    steps_[a] = known_step(groups_, a);
    if (!apart(a, b)) return;
    auto starts = turns(surfaces_[b], surfaces_[a], count);
    const auto steps = steps_about(groups_, a);
    starts.insert(starts.end(), steps.begin(), steps.end());
    keep_promising(surfaces_[a], surfaces_[b], starts);
    steps_[a] = refine(a, b, starts);
  }

  // Between views with one between them, where both steps are known.
  void link_over_next(std::size_t a) {
    const std::size_t count = surfaces_.size(), b = (a + 1) % count, c = (a + 2) % count;
    if (apart(a, c) && steps_[a] && steps_[b]) refine(a, c, {*steps_[b] * *steps_[a]});
  }

  // Adds what fits to the links; the one of largest overlap, if any.
  std::optional<RigidMotion> refine(std::size_t a, std::size_t b,
                                    const std::vector<RigidMotion>& starts) {
    const ViewSurface &view = surfaces_[a], &reference = surfaces_[b];
    const double reach = kSearchRadii * std::min(view.radius(), reference.radius());
    std::vector<PoseHypothesis> found(starts.size());
    parallel_for(starts.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k)
        found[k] = refine_hypothesis(view, reference, starts[k], reach, judge_);
    });
    const PoseHypothesis* best = nullptr;
    for (const PoseHypothesis& hypothesis : found) {
      if (!plausible(hypothesis.evidence, view, reference, limits_) &&
          !may_be_right(hypothesis.evidence, view, reference, limits_))
        continue;
      links_.push_back({a, b, hypothesis.b_from_a, hypothesis.evidence});
      if (!best || hypothesis.evidence.overlap > best->evidence.overlap) best = &hypothesis;
    }
    return best ? std::optional(best->b_from_a) : std::nullopt;
  }

  const std::vector<ViewSurface>& surfaces_;
  const ViewGroups& groups_;
  const VerificationThresholds& limits_;
  const JudgeOptions& judge_;
  std::vector<std::optional<RigidMotion>> steps_;  // From each view to the next, where known.
  std::vector<PoseLink> links_;
};

}  // namespace

std::vector<PoseLink> turntable_links(const std::vector<ViewSurface>& surfaces,
                                      const ViewGroups& groups,
                                      const VerificationThresholds& limits,
                                      const JudgeOptions& judge) {
  return TurntableSearch(surfaces, groups, limits, judge).links();
}

}  // namespace relief::registration
