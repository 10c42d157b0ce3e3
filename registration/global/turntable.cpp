#include "registration/global/turntable.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

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

}  // namespace

std::vector<PoseLink> turntable_links(const std::vector<ViewSurface>& surfaces,
                                      const std::vector<std::size_t>& group,
                                      const VerificationThresholds& limits,
                                      Association association) {
  std::vector<std::pair<std::size_t, std::size_t>> neighbours;
  const std::size_t count = surfaces.size();
  for (std::size_t i = 0; i + 1 < count; ++i) neighbours.emplace_back(i, i + 1);
  if (count > 2) neighbours.emplace_back(0, count - 1);
  std::vector<PoseLink> links;
  for (const auto& [a, b] : neighbours) {
    const ViewSurface &view = surfaces[a], &reference = surfaces[b];
    if (group[a] == group[b] || view.samples().empty() || reference.samples().empty()) continue;
    auto starts = turns(reference, view, count);
    keep_promising(view, reference, starts);
    const double reach = kSearchRadii * std::min(view.radius(), reference.radius());
    std::vector<PoseHypothesis> found(starts.size());
    parallel_for(starts.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k)
        found[k] = refine_hypothesis(view, reference, starts[k], reach, association);
    });
    for (const auto& hypothesis : found)
      if (plausible(hypothesis.evidence, view, reference, limits))
        links.push_back({a, b, hypothesis.b_from_a, hypothesis.evidence});
  }
  return links;
}

}  // namespace relief::registration
