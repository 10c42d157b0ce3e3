#include "registration/verification/given_pose_errors.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "registration/align_surfaces.h"
#include "registration/pairwise/robust.h"
#include "registration/verification/hand_eye.h"

namespace relief::registration {

namespace {

// Guesses that refining moves farther [radii of views] were no guesses of these poses: views may
// have come to rest anywhere. A turn of twelve degrees.
constexpr double kFar = 0.2;
// Pairs that deviate by more than this many times their noise may not belong where they are: three
// quarters of their squared distances are unexplained.
constexpr double kLargeMisfit = 2.0;
// Other poses are far better where pairs deviate by less than this part.
constexpr double kFarBetter = 0.5;

// Guesses agree with the poses found where these are four times nearer, as for a hand-eye motion.
constexpr double kMuchNearer = 0.25;
constexpr std::size_t kFewestVerified = 3;

// What else the file may mean by its poses: the inverse, or rotations that are not of the pose.
std::vector<PoseConvention> readings_of(const PoseConvention& taken) {
  std::vector<PoseConvention> readings{taken};
  for (const bool inverse : {taken.view_from_world, !taken.view_from_world})
    for (const StoredRotation rotation :
         {StoredRotation::kAsRead, StoredRotation::kInverse, StoredRotation::kQuaternionWFirst}) {
      PoseConvention reading = taken;
      reading.view_from_world = inverse;
      reading.rotation = rotation;
      readings.push_back(reading);
    }
  return readings;
}

// Of the pairs, in standard deviations of their noise; 0 without pairs.
double median_misfit(const std::vector<ViewSurface>& surfaces, const Alignment& alignment) {
  std::vector<double> misfits;
  for (const PairFit& pair : alignment.pairs) {
    const double noise = std::hypot(surfaces[pair.a].noise(), surfaces[pair.b].noise());
    if (noise > 0.0) misfits.push_back(pair.rms / noise);
  }
  return misfits.empty() ? 0.0 : quantile(std::move(misfits), 0.5);
}

}  // namespace

bool refining_led_far(const std::vector<RangeView>& views, const std::vector<ViewSurface>& surfaces,
                      const Alignment& alignment, const PoseConvention& taken) {
  std::vector<double> moves;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].pose == PoseKind::kKnown) return false;
    if (views[i].pose == PoseKind::kAbsent || !alignment.views[i].aligned ||
        surfaces[i].samples().empty())
      continue;
    const Eigen::Vector3d& centre = surfaces[i].centre();
    const RigidMotion given = taken.world_from_view(views[i].world_from_view);
    moves.push_back((alignment.views[i].world_from_view * centre - given * centre).norm() /
                    surfaces[i].radius());
  }
  return moves.size() > 2 && quantile(std::move(moves), 0.5) > kFar &&
         median_misfit(surfaces, alignment) > kLargeMisfit;
}

bool fits_far_better(const std::vector<ViewSurface>& surfaces, const Alignment& now,
                     const Alignment& before) {
  return verified_views(now) > 2 &&
         median_misfit(surfaces, now) < kFarBetter * median_misfit(surfaces, before);
}

std::optional<PoseConvention> agreeing_convention(const std::vector<RangeView>& views,
                                                  const std::vector<ViewSurface>& surfaces,
                                                  const Alignment& alignment,
                                                  const PoseConvention& taken) {
  std::vector<std::size_t> verified;
  std::size_t guesses = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].pose == PoseKind::kKnown) return std::nullopt;
    if (views[i].pose == PoseKind::kAbsent || surfaces[i].samples().empty()) continue;
    ++guesses;
    if (alignment.views[i].status == PoseStatus::kVerified) verified.push_back(i);
  }
  if (verified.size() == guesses || verified.size() < kFewestVerified) return std::nullopt;
  const auto poses_in = [&](const PoseConvention& convention) {
    std::vector<GivenAndFound> poses;
    for (const std::size_t i : verified)
      poses.push_back({.name = views[i].name,
                       .given = convention.world_from_view(views[i].world_from_view),
                       .found = alignment.views[i].world_from_view,
                       .centre = surfaces[i].centre()});
    return poses;
  };
  std::optional<PoseConvention> best;
  double wanted = kMuchNearer * median_error({}, poses_in(taken));
  for (const PoseConvention& other : readings_of(taken)) {
    const auto poses = poses_in(other);
    const HandEye hand_eye = calibrate_hand_eye(poses).value_or(HandEye());
    const double error = median_error(hand_eye, poses);
    if (!(error < wanted)) continue;
    wanted = 0.5 * error;  // The first is the simplest.
    best = other;
    best->unit *= hand_eye.scale;
    best->body_from_view = hand_eye.body_from_view;
  }
  return best;
}

}  // namespace relief::registration
