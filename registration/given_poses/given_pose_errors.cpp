#include "registration/given_poses/given_pose_errors.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "registration/align_surfaces.h"
#include "registration/given_poses/hand_eye.h"
#include "registration/pairwise/robust.h"

namespace relief::registration {

namespace {

// Pairs that refining moves farther to each other [radii of views] were not guessed: they may have
// come to rest anywhere. A turn of twelve degrees.
constexpr double kFar = 0.2;
// Pairs that deviate by more than this many times their noise may not belong where they are: three
// quarters of their squared distances are unexplained.
constexpr double kLargeMisfit = 2.0;
// Other poses are far better where pairs deviate by less than this part, or where those that
// determine all motions were less than this part.
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
      if (inverse == taken.view_from_world && rotation == taken.rotation) continue;
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
    const double noise = joint_noise(surfaces[pair.a], surfaces[pair.b]);
    if (noise > 0.0) misfits.push_back(pair.rms / noise);
  }
  return misfits.empty() ? 0.0 : quantile(std::move(misfits), 0.5);
}

double determined_pairs(const Alignment& alignment) {
  return static_cast<double>(
      std::ranges::count(alignment.pairs, PairStatus::kDetermined, &PairFit::status));
}

bool is_guess(const RangeView& view) { return view.pose == PoseKind::kGuess; }

bool any_known(const std::vector<RangeView>& views) {
  return std::ranges::any_of(views,
                             [](const RangeView& view) { return view.pose == PoseKind::kKnown; });
}

}  // namespace

bool refinement_moved_far(const std::vector<RangeView>& views,
                          const std::vector<ViewSurface>& surfaces, const Alignment& alignment,
                          const PoseConvention& taken) {
  if (any_known(views)) return false;
  std::vector<double> moves;
  for (const PairFit& pair : alignment.pairs) {
    const double radius = surfaces[pair.b].radius();
    if (!is_guess(views[pair.a]) || !is_guess(views[pair.b]) || !(radius > 0.0)) continue;
    const RigidMotion given = taken.world_from_view(views[pair.a].world_from_view).inverse() *
                              taken.world_from_view(views[pair.b].world_from_view);
    const RigidMotion found =
        alignment.views[pair.a].world_from_view.inverse() * alignment.views[pair.b].world_from_view;
    moves.push_back(largest_motion(given.inverse() * found, surfaces[pair.b]) / radius);
  }
  return !moves.empty() && quantile(std::move(moves), 0.5) > kFar &&
         median_misfit(surfaces, alignment) > kLargeMisfit;
}

bool has_few_determined_pairs(const std::vector<RangeView>& views, const Alignment& alignment) {
  if (any_known(views)) return false;
  std::size_t determined = 0, failing = 0;
  for (const PairFit& pair : alignment.pairs) {
    if (!is_guess(views[pair.a]) || !is_guess(views[pair.b])) continue;
    determined += pair.status == PairStatus::kDetermined;
    failing += pair.status == PairStatus::kDegenerate || pair.status == PairStatus::kMisfit;
  }
  return failing > determined;
}

bool fits_far_better(const std::vector<ViewSurface>& surfaces, const Alignment& now,
                     const Alignment& before) {
  return verified_views(now) >= kFewestVerified &&
         (median_misfit(surfaces, now) < kFarBetter * median_misfit(surfaces, before) ||
          kFarBetter * determined_pairs(now) > determined_pairs(before));
}

std::optional<PoseConvention> agreeing_convention(const std::vector<RangeView>& views,
                                                  const std::vector<ViewSurface>& surfaces,
                                                  const Alignment& alignment,
                                                  const PoseConvention& taken) {
  if (any_known(views)) return std::nullopt;
  std::vector<std::size_t> verified;
  std::vector<double> spacings;
  std::size_t guesses = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!is_guess(views[i]) || surfaces[i].samples().empty()) continue;
    ++guesses;
    if (alignment.views[i].status != PoseStatus::kVerified) continue;
    verified.push_back(i);
    spacings.push_back(surfaces[i].spacing());
  }
  if (verified.size() == guesses || verified.size() < kFewestVerified) return std::nullopt;
  const auto poses_in = [&](const PoseConvention& convention) {
    std::vector<GivenAndFound> poses;
    for (const std::size_t i : verified)
      poses.push_back({.given = convention.world_from_view(views[i].world_from_view),
                       .found = alignment.views[i].world_from_view,
                       .centre = surfaces[i].centre()});
    return poses;
  };
  std::optional<PoseConvention> best;
  const double as_taken = median_error({}, poses_in(taken));
  if (as_taken <= quantile(std::move(spacings), 0.5)) return std::nullopt;
  double wanted = kMuchNearer * as_taken;
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
