#include "registration/given_poses/kept_poses.h"

#include <algorithm>
#include <cstddef>

#include "registration/pairwise/search_schedule.h"
#include "registration/posegraph/view_graph.h"
#include "registration/verification/pose_evidence.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Of the overlap at given poses.
constexpr double kMinOverlapKept = 0.5;
// Pairs of a view that are compared, the largest overlaps first. Bounds the time.
constexpr int kComparedPairsOfAView = 6;
// What refining may gain where it only follows the errors of the views: of the overlap, of the mean
// square, and of the coherent mean square, beyond what is not told from zero [mean squares]. A pose
// that errs by a seventh of the deviation of distances raises their mean square by 2 %. Rooms of
// coarse or few samples, moved by 1 to 17 cm from exact poses, had 0.92 to 1.006 of it
// (docs/results.md, Poses that stay).
constexpr double kOverlapGain = 1.02, kSquaresGain = 1.02, kCoherentGain = 1.1,
                 kCoherentZero = 0.01;

// Within reach of each other, and as far beyond as makes no doubt [reaches()].
constexpr double kWithinReach = 1.0, kBeyondReach = 2.0;

RigidMotion relative(const ViewPair& pair, const std::vector<RigidMotion>& poses) {
  return poses[pair.b].inverse() * poses[pair.a];
}

std::vector<double> overlaps_of_views(std::size_t views, const std::vector<ViewPair>& pairs) {
  std::vector<double> overlaps(views, 0.0);
  for (const ViewPair& pair : pairs)
    for (const std::size_t i : {pair.a, pair.b}) overlaps[i] += pair.overlap;
  return overlaps;
}

// How pairs fit all in all, each weighed by what it shares.
struct CommonFit {
  double overlap = 0.0;
  double squares = 0.0, coherent_squares = 0.0;  // [unit^2]

  double mean_square() const { return overlap > 0.0 ? squares / overlap : 0.0; }
  double coherent_mean_square() const { return overlap > 0.0 ? coherent_squares / overlap : 0.0; }
};

CommonFit fit_at(const std::vector<ViewSurface>& surfaces, const std::vector<RigidMotion>& poses,
                 const std::vector<ViewPair>& pairs, const JudgeOptions& judging) {
  const auto evidence = parallel_map<PoseEvidence>(pairs.size(), [&](std::size_t k) {
    return judge_pose(surfaces[pairs[k].a], surfaces[pairs[k].b], relative(pairs[k], poses),
                      judging);
  });
  CommonFit fit;
  for (const PoseEvidence& of_pair : evidence) {
    fit.overlap += of_pair.overlap;
    fit.squares += of_pair.overlap * of_pair.rms * of_pair.rms;
    fit.coherent_squares += of_pair.overlap * of_pair.coherent_rms * of_pair.coherent_rms;
  }
  return fit;
}

}  // namespace

GivenAndRefined::GivenAndRefined(const std::vector<ViewSurface>& surfaces,
                                 const std::vector<RigidMotion>& given,
                                 const std::vector<RigidMotion>& refined,
                                 const std::vector<ViewRole>& roles, Association association)
    : surfaces_(surfaces), given_(given), refined_(refined), roles_(roles) {
  judging_.association = association;
  pairs_given_ = overlapping_pairs(given);
  pairs_refined_ = overlapping_pairs(refined);
}

std::vector<ViewPair> GivenAndRefined::overlapping_pairs(
    const std::vector<RigidMotion>& poses) const {
  auto pairs = find_meeting_pairs(surfaces_, poses, 0.0);
  std::erase_if(pairs, [&](const ViewPair& pair) {
    return roles_[pair.a] == ViewRole::kExcluded || roles_[pair.b] == ViewRole::kExcluded;
  });
  parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      pairs[k].overlap = judge_free_space(surfaces_[pairs[k].a], surfaces_[pairs[k].b],
                                          relative(pairs[k], poses), judging_)
                             .overlap;
  });
  std::erase_if(pairs, [](const ViewPair& pair) { return pair.overlap < kCountingOverlap; });
  return pairs;
}

std::vector<bool> GivenAndRefined::views_without_overlap() const {
  const std::size_t views = surfaces_.size();
  const auto before = overlaps_of_views(views, pairs_given_),
             after = overlaps_of_views(views, pairs_refined_);
  std::vector<bool> lost(views);
  for (std::size_t i = 0; i < views; ++i)
    lost[i] = roles_[i] == ViewRole::kFree && after[i] < kMinOverlapKept * before[i];
  return lost;
}

// By a motion of this view alone [reaches within which refining looks for partners].
double GivenAndRefined::reaches(const ViewPair& pair, const RigidMotion& of_a) const {
  const double radius = std::min(surfaces_[pair.a].radius(), surfaces_[pair.b].radius());
  return largest_motion(of_a, surfaces_[pair.a]) / (kFirstSearchRadii * radius);
}

std::vector<bool> GivenAndRefined::coincident_views() const {
  std::vector<bool> laid(surfaces_.size());
  for (const ViewPair& pair : pairs_refined_)
    if (reaches(pair, relative(pair, refined_)) <= kWithinReach &&
        reaches(pair, relative(pair, given_)) >= kBeyondReach)
      for (const std::size_t i : {pair.a, pair.b}) laid[i] = roles_[i] == ViewRole::kFree;
  return laid;
}

std::vector<bool> GivenAndRefined::views_laid_on_planes(const std::vector<PairFit>& pairs) const {
  const auto moved_far = [&](const ViewPair& pair) {
    return reaches(pair, relative(pair, given_).inverse() * relative(pair, refined_)) >=
           kBeyondReach;
  };
  const auto determined = [&](const ViewPair& pair) {
    return std::ranges::any_of(pairs, [&](const PairFit& fit) {
      return fit.a == pair.a && fit.b == pair.b && fit.degenerate_directions.empty();
    });
  };
  // Takes out those that share more than a plane with another one at these poses.
  const auto keep_planar = [&](const std::vector<ViewPair>& overlapping,
                               const std::vector<RigidMotion>& poses, std::vector<bool>& views) {
    for (const ViewPair& pair : overlapping)
      if ((views[pair.a] || views[pair.b]) &&
          (determined(pair) || !shares_one_plane(surfaces_[pair.a], surfaces_[pair.b],
                                                 relative(pair, poses), judging_)))
        views[pair.a] = views[pair.b] = false;
  };
  std::vector<bool> laid(surfaces_.size(), false);
  for (const ViewPair& pair : pairs_refined_)
    if (moved_far(pair))
      for (const std::size_t i : {pair.a, pair.b}) laid[i] = roles_[i] == ViewRole::kFree;
  keep_planar(pairs_refined_, refined_, laid);
  if (std::ranges::find(laid, true) == laid.end()) return laid;
  // What stands still may lead views off all others, too.
  auto lost = views_without_overlap();
  keep_planar(pairs_given_, given_, lost);
  for (std::size_t i = 0; i < laid.size(); ++i) laid[i] = laid[i] || lost[i];
  return laid;
}

bool GivenAndRefined::given_fit_as_well() const {
  const auto pairs = largest_overlaps(surfaces_.size(), pairs_refined_, kComparedPairsOfAView);
  const CommonFit at_given = fit_at(surfaces_, given_, pairs, judging_),
                  at_refined = fit_at(surfaces_, refined_, pairs, judging_);
  if (at_given.overlap <= 0.0 || at_refined.overlap > kOverlapGain * at_given.overlap) return false;
  return at_given.mean_square() <= kSquaresGain * at_refined.mean_square() &&
         at_given.coherent_mean_square() <= kCoherentGain * at_refined.coherent_mean_square() +
                                                kCoherentZero * at_refined.mean_square();
}

}  // namespace relief::registration
