#include "registration/posegraph/joint_refinement.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "registration/pairwise/robust.h"
#include "registration/pairwise/search_schedule.h"
#include "registration/posegraph/joint_solver.h"
#include "registration/posegraph/loops/loop_closure.h"
#include "registration/posegraph/pairs/pair_matcher.h"
#include "registration/posegraph/refinement/pose_graph_refinement.h"
#include "registration/posegraph/view_graph.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Of all pairs at a time, before the last steps, which use all samples. Bounds the memory.
constexpr std::size_t kMostCorrespondences = 250'000;
// Of one direction of a pair, where many pairs are solved for together, and where one is judged:
// 40 and 120 residuals a pair, for six unknowns.
constexpr int kFewestTogether = 20, kFewestAlone = 60;
// All pairs of hundreds of views would get so few samples each that most of a view goes unused, and
// they need gigabytes. What a view's pairs share is its own noise: with n of them its pose errs by
// the root of 1 + 1/n times what all could give, 2 % more for 24.
constexpr int kMostPairsOfAView = 24;
// The last steps are precise enough to stop at less than the levels before them [tolerances]. Poses
// err by one, and a last step follows anyway. Smaller costs steps, of which there are 6 at most.
constexpr double kFinalTolerance = 0.5;
// Residuals of all pairs together in the last step: some ten seconds of processor time. The steps
// before it take a quarter: they err by twice as much, and the last step leaves a tenth of that.
constexpr std::size_t kMostLastResiduals = 50'000'000;
constexpr std::size_t kMostStepResiduals = kMostLastResiduals / 4;

std::vector<SearchLevel> levels_for(const std::vector<ViewSurface>& surfaces,
                                    const JointRefinementOptions& options, int signal_levels) {
  std::vector<double> spacings, noises, radii;
  for (const auto& surface : surfaces) {
    if (surface.samples().empty()) continue;
    spacings.push_back(surface.spacing());
    noises.push_back(surface.noise());
    radii.push_back(surface.radius());
  }
  SearchScheduleOptions schedule;
  schedule.levels = options.levels;
  schedule.signal_levels = signal_levels;
  schedule.correspondences = options.correspondences;
  schedule.first_distance = options.search_distance > 0.0
                                ? options.search_distance
                                : kFirstSearchRadii * quantile(radii, 0.5);
  schedule.last_distance =
      finest_search_distance(quantile(spacings, 1.0), std::sqrt(2.0) * quantile(noises, 1.0));
  schedule.tolerance = options.tolerance * quantile(spacings, 0.0);
  return search_schedule(schedule);
}

std::vector<ViewPair> pairs_at(const std::vector<ViewSurface>& surfaces,
                               const std::vector<RigidMotion>& world_from_view,
                               const std::vector<ViewRole>& roles, const SearchLevel& level,
                               const JointRefinementOptions& options) {
  ViewGraphOptions graph;
  graph.max_distance = level.max_distance;
  graph.max_normal_angle_deg = options.max_normal_angle_deg;
  graph.min_overlap = options.min_overlap;
  graph.min_correspondences = options.min_correspondences;
  graph.association = options.association;
  auto pairs = find_overlapping_pairs(surfaces, world_from_view, graph);
  std::erase_if(pairs, [&](const ViewPair& pair) {
    return roles[pair.a] == ViewRole::kExcluded || roles[pair.b] == ViewRole::kExcluded;
  });
  return pairs;
}

// Hundreds of views have thousands of pairs: each then needs fewer, for the same number per view.
CorrespondenceOptions search_at(const SearchLevel& level, std::size_t pairs, int fewest,
                                const JointRefinementOptions& options) {
  const std::size_t share = kMostCorrespondences / std::max<std::size_t>(1, 2 * pairs);
  CorrespondenceOptions search;
  search.count = std::min(level.count, std::max(static_cast<int>(share), fewest));
  search.max_distance = level.max_distance;
  search.max_normal_angle_deg = options.max_normal_angle_deg;
  search.association = options.association;
  return search;
}

// Views that all their correspondences together hardly hold, and that have normal maps: geometry
// that holds a view well needs no help from maps, whose errors are less well known.
std::vector<bool> nearly_degenerate_views(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<RigidMotion>& world_from_view,
                                          const std::vector<DirectedMatches>& matches) {
  std::vector<std::vector<OrientedPoint>> points(surfaces.size());
  for (const auto& directed : matches) {
    const RigidMotion& pose = world_from_view[directed.target];
    for (const auto& c : directed.found.items)
      for (const std::size_t view : {directed.source, directed.target})
        points[view].push_back({pose * c.target.point, pose.linear() * c.target.normal});
  }
  std::vector<bool> nearly_degenerate(surfaces.size());
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    nearly_degenerate[i] = surfaces[i].signal_levels() > 0 && !points[i].empty() &&
                           is_nearly_degenerate(analyse_constraints(points[i]),
                                                eigenvalue_threshold(surfaces[i].normal_noise()));
  return nearly_degenerate;
}

// How to search, coarse to fine, and for which views by normal maps too.
struct SearchPlan {
  std::vector<SearchLevel> levels;
  std::vector<bool> nearly_degenerate;
};

SearchPlan plan_search(const std::vector<ViewSurface>& surfaces,
                       const std::vector<RigidMotion>& world_from_view,
                       const std::vector<ViewRole>& roles, const JointRefinementOptions& options) {
  SearchPlan plan{levels_for(surfaces, options, 0), std::vector<bool>(surfaces.size(), false)};
  int signal_levels = 0;
  for (const auto& surface : surfaces)
    signal_levels = std::max(signal_levels, surface.signal_levels());
  if (signal_levels == 0) return plan;
  const auto pairs = largest_overlaps(
      surfaces.size(), pairs_at(surfaces, world_from_view, roles, plan.levels.front(), options),
      kMostPairsOfAView);
  const SearchLevel& level = plan.levels.front();
  const PairMatcher match(surfaces, world_from_view, pairs,
                          search_at(level, pairs.size(), kFewestTogether, options),
                          level.signal_level, plan.nearly_degenerate);
  const auto matches = parallel_map<DirectedMatches>(match.size(), match);
  plan.nearly_degenerate = nearly_degenerate_views(surfaces, world_from_view, matches);
  if (std::find(plan.nearly_degenerate.begin(), plan.nearly_degenerate.end(), true) !=
      plan.nearly_degenerate.end())
    plan.levels = levels_for(surfaces, options, signal_levels);
  return plan;
}

// The gauge: one held view in every group that has none.
std::vector<bool> hold_one_per_group(const std::vector<std::size_t>& group,
                                     const std::vector<ViewRole>& roles) {
  std::vector<bool> has_held(group.size(), false), held(group.size());
  for (std::size_t i = 0; i < group.size(); ++i) held[i] = roles[i] != ViewRole::kFree;
  for (std::size_t i = 0; i < group.size(); ++i)
    if (held[i]) has_held[group[i]] = true;
  for (std::size_t i = 0; i < group.size(); ++i)
    if (group[i] == i && !has_held[i]) held[i] = true;
  return held;
}

// Pair by pair: all matches of hundreds of views would need more memory than all else.
void describe_fit(const PairMatcher& match, const std::vector<ViewSurface>& surfaces,
                  JointRefinement& result) {
  result.pairs = parallel_map<PairFit>(match.size() / 2, [&](std::size_t k) {
    return fit_of(surfaces, result.world_from_view, match(2 * k), match(2 * k + 1));
  });
  double squares = 0.0;
  std::size_t count = 0;
  for (const PairFit& fit : result.pairs) {
    squares += fit.rms * fit.rms * static_cast<double>(fit.correspondences);
    count += fit.correspondences;
  }
  set_pair_statuses(surfaces, result.pairs);
  if (count > 0) result.rms = std::sqrt(squares / static_cast<double>(count));
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

// The last steps, with all samples of the strongest pairs; gives the covariance too. Returns what
// the very last one was made of.
PoseGraphLastStep finish(const std::vector<ViewSurface>& surfaces,
                         const std::vector<ViewPair>& pairs, const SearchLevel& level,
                         const std::vector<bool>& nearly_degenerate,
                         const JointRefinementOptions& options, JointRefinement& result) {
  PoseGraphRefinementOptions last;
  last.search = search_at(level, pairs.size(), kFewestAlone, options);
  last.last_samples = last_samples(options, pairs.size());
  last.step_samples =
      std::min({last.step_samples, last.last_samples, share_of(kMostStepResiduals, pairs.size())});
  last.tolerance = kFinalTolerance * level.tolerance;
  if (std::find(nearly_degenerate.begin(), nearly_degenerate.end(), true) !=
      nearly_degenerate.end()) {
    const PairMatcher match(surfaces, result.world_from_view, pairs, last.search,
                            level.signal_level, nearly_degenerate);
    last.normals = parallel_map<NormalMatches>(match.size(), [&](std::size_t i) {
      return match.by_normal_maps(i) ? match(i).normals : NormalMatches();
    });
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

Result<JointRefinement> refine_jointly(const std::vector<ViewSurface>& surfaces,
                                       const std::vector<RigidMotion>& world_from_view,
                                       const std::vector<ViewRole>& roles,
                                       const JointRefinementOptions& options,
                                       const Progress& progress) {
  assert(surfaces.size() == world_from_view.size() && surfaces.size() == roles.size());
  JointRefinement result;
  result.world_from_view = world_from_view;
  result.group = connected_groups(surfaces.size(), {});
  result.held = hold_one_per_group(result.group, roles);
  result.pose_covariance.assign(surfaces.size(), Matrix6d::Zero());
  result.pose_std.assign(surfaces.size(), RigidTangent::Zero());
  const bool any_samples = std::any_of(surfaces.begin(), surfaces.end(), [](const auto& s) {
    return !s.samples().empty() && s.spacing() > 0.0;
  });
  if (!any_samples) return result;

  const auto [levels, nearly_degenerate] = plan_search(surfaces, world_from_view, roles, options);
  std::vector<ViewPair> pairs;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    pairs = pairs_at(surfaces, result.world_from_view, roles, levels[l], options);
    if (pairs.empty()) break;
    result.group = connected_groups(surfaces.size(), pairs);
    result.held = hold_one_per_group(result.group, roles);
    result.termination = RefinementTermination::kIterationLimit;
    const JointSolverOptions solver{};
    const auto strongest = largest_overlaps(surfaces.size(), pairs, kMostPairsOfAView);
    for (int i = 0; i < options.max_iterations; ++i) {
      const double fraction = (l + static_cast<double>(i) / options.max_iterations) / levels.size();
      if (!report_progress(progress, fraction, "refining poses"))
        return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
      const PairMatcher match(surfaces, result.world_from_view, strongest,
                              search_at(levels[l], strongest.size(), kFewestTogether, options),
                              levels[l].signal_level, nearly_degenerate);
      auto matches = parallel_map<DirectedMatches>(match.size(), match);
      const auto before = result.world_from_view;
      result.solves.push_back(
          solve_poses(surfaces, std::move(matches), result.held, solver, result.world_from_view));
      if (result.solves.back().termination == SolverTermination::kFailed) {
        result.termination = RefinementTermination::kSolverFailed;
        return result;
      }
      ++result.iterations;
      result.last_motion = largest_motion(pointers_to(surfaces), before, result.world_from_view);
      if (result.last_motion <= levels[l].tolerance) {
        result.termination = RefinementTermination::kConverged;
        break;
      }
    }
  }
  if (pairs.empty()) {
    result.termination = RefinementTermination::kNoOverlap;
    result.group = connected_groups(surfaces.size(), {});
    return result;
  }
  release_freed_memory();  // What solving took; the last steps grow as large.
  if (!report_progress(progress, 0.0, "computing covariances"))
    return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
  const PoseGraphLastStep last_step =
      finish(surfaces, largest_overlaps(surfaces.size(), pairs, kMostPairsOfAView), levels.back(),
             nearly_degenerate, options, result);
  if (result.termination == RefinementTermination::kSolverFailed) return result;
  const SearchLevel& last = levels.back();
  describe_fit(PairMatcher(surfaces, result.world_from_view, pairs,
                           search_at(last, pairs.size(), kFewestAlone, options), last.signal_level,
                           nearly_degenerate),
               surfaces, result);
  result.loops = loop_closures(surfaces, result.world_from_view, last_step, result.pairs);
  return result;
}

std::string_view to_string(RefinementTermination termination) {
  switch (termination) {
    case RefinementTermination::kConverged:
      return "converged";
    case RefinementTermination::kIterationLimit:
      return "iteration limit";
    case RefinementTermination::kNoOverlap:
      return "no overlap";
    case RefinementTermination::kSolverFailed:
      return "solver failed";
  }
  return "unknown";
}

}  // namespace relief::registration
