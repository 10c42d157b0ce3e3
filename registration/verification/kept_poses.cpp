#include "registration/verification/kept_poses.h"

#include <cstddef>

#include "registration/pairwise/search_schedule.h"
#include "registration/posegraph/view_graph.h"
#include "registration/verification/pose_evidence.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Of the overlap at given poses, less than this is left of a view that was lost.
constexpr double kLeftOfLost = 0.5;
// Pairs of a view that are compared, the largest overlaps first. Bounds the time.
constexpr int kComparedPairsOfAView = 6;
// What refining may gain where it only follows the errors of the views: of the overlap, of the mean
// square, and of the coherent mean square, beyond what is not told from zero [mean squares]. A pose
// that errs by a seventh of the deviation of distances raises their mean square by 2 %. Rooms of
// coarse or few samples, moved by 1 to 17 cm from exact poses, had 0.92 to 1.006 of it
// (docs/results.md, Poses that stay).
constexpr double kOverlapGain = 1.02, kSquaresGain = 1.02, kCoherentGain = 1.1,
                 kCoherentZero = 0.01;

std::vector<ViewPair> free_pairs(const std::vector<ViewSurface>& surfaces,
                                 const std::vector<RigidMotion>& poses,
                                 const std::vector<ViewRole>& roles) {
  auto pairs = find_meeting_pairs(surfaces, poses, 0.0);
  std::erase_if(pairs, [&](const ViewPair& pair) {
    return roles[pair.a] == ViewRole::kExcluded || roles[pair.b] == ViewRole::kExcluded;
  });
  return pairs;
}

RigidMotion relative(const ViewPair& pair, const std::vector<RigidMotion>& poses) {
  return poses[pair.b].inverse() * poses[pair.a];
}

// The pairs that overlap.
std::vector<ViewPair> overlapping_pairs(const std::vector<ViewSurface>& surfaces,
                                        const std::vector<RigidMotion>& poses,
                                        const std::vector<ViewRole>& roles,
                                        const JudgeOptions& judging) {
  auto pairs = free_pairs(surfaces, poses, roles);
  parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      pairs[k].overlap = judge_free_space(surfaces[pairs[k].a], surfaces[pairs[k].b],
                                          relative(pairs[k], poses), judging)
                             .overlap;
  });
  std::erase_if(pairs, [](const ViewPair& pair) { return pair.overlap < kCountingOverlap; });
  return pairs;
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

JudgeOptions judging_with(Association association) {
  JudgeOptions judging;
  judging.association = association;
  return judging;
}

}  // namespace

std::vector<bool> lost_views(const std::vector<ViewSurface>& surfaces,
                             const std::vector<RigidMotion>& given,
                             const std::vector<RigidMotion>& refined,
                             const std::vector<ViewRole>& roles, Association association) {
  const JudgeOptions judging = judging_with(association);
  const std::size_t views = surfaces.size();
  const auto before = overlaps_of_views(views, overlapping_pairs(surfaces, given, roles, judging)),
             after = overlaps_of_views(views, overlapping_pairs(surfaces, refined, roles, judging));
  std::vector<bool> lost(views);
  for (std::size_t i = 0; i < views; ++i)
    lost[i] = roles[i] == ViewRole::kFree && after[i] < kLeftOfLost * before[i];
  return lost;
}

std::vector<bool> views_laid_on_each_other(const std::vector<ViewSurface>& surfaces,
                                           const std::vector<RigidMotion>& given,
                                           const std::vector<RigidMotion>& refined,
                                           const std::vector<ViewRole>& roles,
                                           Association association) {
  const auto apart = [&](const ViewPair& pair, const std::vector<RigidMotion>& poses) {
    return largest_motion(relative(pair, poses), surfaces[pair.a]) /
           (kFirstSearchRadii * surfaces[pair.a].radius());
  };
  std::vector<bool> laid(surfaces.size());
  for (const ViewPair& pair :
       overlapping_pairs(surfaces, refined, roles, judging_with(association)))
    if (apart(pair, refined) <= 1.0 && apart(pair, given) >= 2.0)
      for (const std::size_t i : {pair.a, pair.b}) laid[i] = roles[i] == ViewRole::kFree;
  return laid;
}

bool fit_as_well_as_refined(const std::vector<ViewSurface>& surfaces,
                            const std::vector<RigidMotion>& given,
                            const std::vector<RigidMotion>& refined,
                            const std::vector<ViewRole>& roles, Association association) {
  const JudgeOptions judging = judging_with(association);
  const auto pairs = largest_overlaps(
      surfaces.size(), overlapping_pairs(surfaces, refined, roles, judging), kComparedPairsOfAView);
  const CommonFit at_given = fit_at(surfaces, given, pairs, judging),
                  at_refined = fit_at(surfaces, refined, pairs, judging);
  if (at_given.overlap <= 0.0 || at_refined.overlap > kOverlapGain * at_given.overlap) return false;
  return at_given.mean_square() <= kSquaresGain * at_refined.mean_square() &&
         at_given.coherent_mean_square() <=
             kCoherentGain * at_refined.coherent_mean_square() +
                 kCoherentZero * at_refined.mean_square();
}

}  // namespace relief::registration
