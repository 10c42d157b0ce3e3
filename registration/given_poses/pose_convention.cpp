#include "registration/given_poses/pose_convention.h"

#include <algorithm>
#include <cassert>

#include "registration/pairwise/robust.h"
#include "registration/verification/pose_evidence.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Views that are compared with all others. Bounds the time, and tells a mean of 0.3 from one of 0.
constexpr std::size_t kMostViews = 12;
// How far guesses may be off [radii of a view], a turn of 3 degrees. More takes the wrong way round
// a turntable for the right one.
constexpr double kReachRadii = 0.05;
// Part of the samples by which another convention must be better: as much as two views share that
// are joined without a third (ViewGroupOptions::lone_overlap).
constexpr double kClearlyBetter = 0.3;

std::vector<PoseConvention> all_conventions() {
  std::vector<PoseConvention> all;
  for (const double unit : {1.0, 0.001, 1000.0})
    for (const bool view_from_world : {false, true})
      for (const Eigen::Matrix3d& axes :
           {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), opengl_axes()})
        all.push_back({unit, view_from_world, axes});
  return all;
}

// The mean over views of their agreement with the other view that they fit best, in [0, 1].
class Agreement {
 public:
  Agreement(const std::vector<ViewSurface>& surfaces, const std::vector<bool>& given)
      : surfaces_(surfaces) {
    std::vector<double> radii;
    for (std::size_t i = 0; i < surfaces.size(); ++i)
      if (given[i] && !surfaces[i].samples().empty()) {
        views_.push_back(i);
        radii.push_back(surfaces[i].radius());
      }
    reach_ = kReachRadii * quantile(std::move(radii), 0.5);
    const std::size_t stride = 1 + views_.size() / kMostViews;
    for (std::size_t k = 0; k < views_.size(); k += stride) compared_.push_back(views_[k]);
  }

  double of_given(const std::vector<RigidMotion>& world_from_view) const {
    return mean_agreement(world_from_view, true);
  }

  // In another convention views that only_rolls() holds for say nothing.
  double of_other(const std::vector<RigidMotion>& world_from_view) const {
    return mean_agreement(world_from_view, false);
  }

  // Whether poses differ by so little that all views stand at one place, where large planes meet
  // whatever the poses are.
  bool at_one_place(const std::vector<RigidMotion>& world_from_view) const {
    return std::ranges::all_of(views_, [&](std::size_t i) {
      const RigidMotion &pose = world_from_view[i], &first = world_from_view[views_.front()];
      return (pose.translation() - first.translation()).norm() <= reach_;
    });
  }

 private:
  double mean_agreement(const std::vector<RigidMotion>& world_from_view, bool as_given) const {
    const auto best = parallel_map<double>(compared_.size(), [&](std::size_t k) {
      return best_agreement(compared_[k], world_from_view, as_given);
    });
    double sum = 0.0;
    for (const double agreement : best) sum += agreement;
    return compared_.empty() ? 0.0 : sum / static_cast<double>(compared_.size());
  }

  double best_agreement(std::size_t i, const std::vector<RigidMotion>& poses, bool as_given) const {
    double best = 0.0;
    for (const std::size_t j : views_) {
      check_stop_and_memory();  // All views are looked at.
      const RigidMotion j_from_i = poses[j].inverse() * poses[i];
      if (j != i && (as_given || !only_rolls(j_from_i, surfaces_[i].centre())))
        best = std::max(
            best, rough_agreement(surfaces_[i], surfaces_[j], j_from_i, reach_, kRoughProbes));
    }
    return best;
  }

  const std::vector<ViewSurface>& surfaces_;
  std::vector<std::size_t> views_, compared_;
  double reach_ = 0.0;
};

}  // namespace

PoseConvention find_pose_convention(const std::vector<ViewSurface>& surfaces,
                                    const std::vector<RigidMotion>& poses,
                                    const std::vector<bool>& given) {
  assert(surfaces.size() == poses.size() && surfaces.size() == given.size());
  const Agreement agreement_in(surfaces, given);
  PoseConvention best;
  double agreement = agreement_in.of_given(poses), wanted = agreement + kClearlyBetter;
  for (const PoseConvention& other : all_conventions()) {
    if (wanted >= 1.0 || other.as_given()) continue;
    std::vector<RigidMotion> world_from_view;
    for (const RigidMotion& pose : poses) world_from_view.push_back(other.world_from_view(pose));
    if (other.unit != 1.0 && agreement_in.at_one_place(world_from_view)) continue;
    agreement = agreement_in.of_other(world_from_view);
    if (agreement <= wanted) continue;
    wanted = agreement;
    best = other;
  }
  return best;
}

}  // namespace relief::registration
