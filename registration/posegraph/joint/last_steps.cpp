#include "registration/posegraph/joint/last_steps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "registration/pairwise/shared_surface.h"
#include "registration/posegraph/loops/loop_closure.h"
#include "registration/posegraph/pairs/pair_fit.h"
#include "registration/posegraph/pairs/pair_matcher.h"
#include "registration/posegraph/pose_step.h"
#include "registration/posegraph/refinement/pose_graph_refinement.h"
#include "scan/base/parallel.h"
#include "scan/base/parallel_batches.h"

namespace relief::registration {

namespace {

// Of one direction of a pair: 120 residuals a pair, for six unknowns, where one is judged.
constexpr int kFewestAlone = 60;
// The last steps are precise enough to stop at less than the levels before them [tolerances]. Poses
// err by one, and a last step follows anyway. Smaller costs steps, most often up to 6.
constexpr double kFinalTolerance = 0.5;
// Residuals of all pairs together in the last step: some ten seconds of processor time. The steps
// before it take a quarter: they err by twice as much, and the last step leaves a tenth of that.
constexpr std::size_t kMostLastResiduals = 50'000'000;
constexpr std::size_t kMostStepResiduals = kMostLastResiduals / 4;

PairConstraint constraint_of(std::size_t a, std::size_t b, const SharedSurface& shared,
                             const Eigen::Vector3d& centre) {
  PairConstraint constraint{a, b, SharedConstraintSum(centre, 1.0)};
  for (std::size_t i = 0; i < shared.points.size(); ++i)
    constraint.shared.add(shared.points[i], shared.normals[i]);
  return constraint;
}

// Pair by pair: all matches of hundreds of views would need more memory than all else. Returns what
// the pairs share.
std::vector<PairConstraint> describe_fit(const PairMatcher& match,
                                         const std::vector<ViewSurface>& surfaces,
                                         JointRefinement& result) {
  struct Described {
    PairFit fit;
    PairConstraint constraint;
  };
  const auto& poses = result.world_from_view;
  const Eigen::Vector3d centre = common_centre(pointers_to(surfaces), poses);
  auto described = parallel_map<Described>(match.size() / 2, [&](std::size_t k) {
    const DirectedMatches there = match(2 * k), back = match(2 * k + 1);
    const std::size_t a = there.source, b = there.target;
    const SharedSurface shared(poses[a], poses[b], there.found, back.found);
    return Described{fit_of(surfaces, poses, shared, there, back),
                     constraint_of(a, b, shared, centre)};
  });
  result.pairs.clear();
  std::vector<PairConstraint> constraints;
  double squares = 0.0;
  std::size_t count = 0;
  for (auto& [fit, constraint] : described) {
    squares += fit.rms * fit.rms * static_cast<double>(fit.correspondences);
    count += fit.correspondences;
    result.pairs.push_back(std::move(fit));
    constraints.push_back(std::move(constraint));
  }
  set_pair_statuses(surfaces, result.pairs);
  if (count > 0) result.rms = std::sqrt(squares / static_cast<double>(count));
  return constraints;
}

// Of one direction of a pair.
std::size_t share_of(std::size_t residuals, std::size_t pairs) {
  return std::max<std::size_t>(1000, residuals / (2 * pairs));
}

std::size_t last_samples(const JointRefinementOptions& options, std::size_t pairs) {
  const std::size_t share = share_of(kMostLastResiduals, pairs);
  const auto wanted = static_cast<std::size_t>(options.final_samples);
  return wanted == 0 ? share : std::min(wanted, share);
}

bool all_finite(const std::vector<RigidMotion>& poses) {
  return std::all_of(poses.begin(), poses.end(),
                     [](const RigidMotion& pose) { return pose.matrix().allFinite(); });
}

// Whether they are finite; sets them.
bool set_covariances(const PoseCovariance& covariance, JointRefinement& result) {
  std::vector<Matrix6d> covariances;
  std::vector<RigidTangent> deviations;
  for (std::size_t i = 0; i < result.pose_std.size(); ++i) {
    covariances.push_back(covariance.of(i));
    if (!covariances.back().allFinite()) return false;
    deviations.push_back(covariances.back().diagonal().cwiseMax(0.0).cwiseSqrt());
  }
  result.pose_covariance = std::move(covariances);
  result.pose_std = std::move(deviations);
  result.joint_covariance = covariance;
  return true;
}

// What the normal maps say of each directed pair.
NormalMatchesOfPairs normal_matches_of_pairs(const PairMatcher& match) {
  NormalMatchesOfPairs matches;
  parallel_map_in_batches<NormalMatches>(
      match.size(), kMatchedAtOnce,
      [&](std::size_t i) { return match.by_normal_maps(i) ? match(i).normals : NormalMatches(); },
      [&](std::size_t, const NormalMatches& of_pair) { matches.add(of_pair); });
  return matches;
}

// Gives the covariance too. Returns what the very last step was made of.
PoseGraphLastStep refine(const std::vector<ViewSurface>& surfaces,
                         const std::vector<ViewPair>& pairs, const SearchLevel& level,
                         const std::vector<bool>& nearly_degenerate, int most_steps,
                         const JointRefinementOptions& options, JointRefinement& result) {
  PoseGraphRefinementOptions last;
  last.max_iterations = most_steps;
  last.kept_motions = result.kept_motions;
  last.search = search_at(level, pairs.size(), kFewestAlone, options);
  last.last_samples = last_samples(options, pairs.size());
  last.step_samples =
      std::min({last.step_samples, last.last_samples, share_of(kMostStepResiduals, pairs.size())});
  last.tolerance = kFinalTolerance * level.tolerance;
  if (std::find(nearly_degenerate.begin(), nearly_degenerate.end(), true) !=
      nearly_degenerate.end()) {
    const PairMatcher match(surfaces, result.world_from_view, pairs, last.search,
                            level.signal_level, nearly_degenerate);
    last.normals = normal_matches_of_pairs(match);
  }
  auto poses = result.world_from_view;
  auto refined = refine_pose_graph(pointers_to(surfaces), pairs, result.held, last, poses);
  result.solves.insert(result.solves.end(), refined.solves.begin(), refined.solves.end());
  if (!refined.solved || !all_finite(poses) || !set_covariances(refined.covariance, result)) {
    result.termination = RefinementTermination::kSolverFailed;
    return {};
  }
  result.world_from_view = std::move(poses);
  result.iterations += refined.iterations;
  result.last_motion = refined.last_motion;
  if (refined.last_motion > level.tolerance)
    result.termination = RefinementTermination::kIterationLimit;
  return std::move(refined.last);
}

}  // namespace

std::vector<PairConstraint> take_last_steps(const std::vector<ViewSurface>& surfaces,
                                            const LinkedPairs& pairs, const SearchLevel& level,
                                            const std::vector<bool>& nearly_degenerate,
                                            MotionsOfViews kept_motions, int most_steps,
                                            const JointRefinementOptions& options,
                                            JointRefinement& result) {
  result.kept_motions = std::move(kept_motions);
  const PoseGraphLastStep last_step =
      refine(surfaces, pairs.strongest, level, nearly_degenerate, most_steps, options, result);
  if (result.termination == RefinementTermination::kSolverFailed) return {};
  auto shared = describe_fit(PairMatcher(surfaces, result.world_from_view, pairs.all,
                                         search_at(level, pairs.all.size(), kFewestAlone, options),
                                         level.signal_level, nearly_degenerate),
                             surfaces, result);
  result.loops = loop_closures(surfaces, result.world_from_view, last_step, result.pairs);
  return shared;
}

}  // namespace relief::registration
