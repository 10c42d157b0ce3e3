#include "registration/posegraph/joint/joint_refinement.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "registration/pairwise/robust.h"
#include "registration/pairwise/search_schedule.h"
#include "registration/posegraph/joint/degenerate_groups.h"
#include "registration/posegraph/joint/joint_solver.h"
#include "registration/posegraph/joint/last_steps.h"
#include "registration/posegraph/pairs/pair_matcher.h"
#include "registration/posegraph/refinement/pose_graph_refinement.h"
#include "registration/posegraph/view_graph.h"
#include "relief/scan/page_allocator.h"
#include "scan/base/parallel.h"
#include "scan/base/parallel_batches.h"

namespace relief::registration {

namespace {

// Of one direction of a pair: 40 residuals a pair, for six unknowns, where many are solved for
// together.
constexpr int kFewestTogether = 20;
// All pairs of hundreds of views would get so few samples each that most of a view goes unused, and
// they need gigabytes. What a view's pairs share is its own noise: with n of them its pose errs by
// the root of 1 + 1/n times what all could give, 2 % more for 24.
constexpr int kMostPairsOfAView = 24;
// Last steps before degenerate directions are looked for, and after: along what only noise holds,
// many steps would lead far. See PoseGraphRefinementOptions::max_iterations.
constexpr int kFirstLastSteps = 6, kMostLastSteps = 60;
// What is left of the overlaps of all pairs without a drift, and by what their RMS may grow. Where
// a drift changes nothing else they are 1: rooms with blurred depths gave 0.97 and 1.03. Where
// views had gone elsewhere they were 0.6 to 0.75, or the RMS doubled.
constexpr double kSharedStill = 0.9, kWorseFit = 1.25;
// What is left without a drift of the relief along it. Two boxes on a table, views of which were
// guessed 3 degrees and 2 cm off: 0.1 to 0.5; guessed well: 0.95 to 1.
constexpr double kReliefStill = 0.8;

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

// Views that all their correspondences together hardly hold, and that have normal maps: geometry
// that holds a view well needs no help from maps, whose errors are less well known.
std::vector<bool> nearly_degenerate_views(const std::vector<ViewSurface>& surfaces,
                                          const std::vector<RigidMotion>& world_from_view,
                                          const PairMatcher& match) {
  std::vector<PagedVector<OrientedPoint>> points(surfaces.size());
  const auto add_points = [&](std::size_t, const DirectedMatches& directed) {
    const RigidMotion& pose = world_from_view[directed.target];
    for (const auto& c : directed.found.items)
      for (const std::size_t view : {directed.source, directed.target})
        points[view].push_back({pose * c.target.point, pose.linear() * c.target.normal});
  };
  parallel_map_in_batches<DirectedMatches>(match.size(), kMatchedAtOnce, match, add_points);
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
  plan.nearly_degenerate = nearly_degenerate_views(surfaces, world_from_view, match);
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

// Whether normal maps determine a pair of a view in the group and one outside it.
bool held_by_maps(const DegenerateGroup& group, const std::vector<PairFit>& pairs) {
  const auto inside = [&](std::size_t i) { return std::ranges::binary_search(group.views, i); };
  return std::ranges::any_of(pairs, [&](const PairFit& pair) {
    return pair.normal_maps && pair.degenerate_directions.empty() &&
           inside(pair.a) != inside(pair.b);
  });
}

double total_overlap(const JointRefinement& result) {
  double total = 0.0;
  for (const PairFit& pair : result.pairs) total += pair.overlap;
  return total;
}

// Without drift the views share nearly what they shared, and lie on each other nearly as they did.
bool fits_as_well(const JointRefinement& result, const JointRefinement& refined) {
  return total_overlap(result) >= kSharedStill * total_overlap(refined) &&
         result.rms <= kWorseFit * refined.rms;
}

// Whether the views shared relief along the motions where they were refined to, little as it is
// beside noise, and share less of it without the drift. What only noise holds is held as well
// there.
bool loses_relief(const MotionConstraint& without_drift, const MotionConstraint& refined) {
  return refined.correlation() >= kNoSharedRelief &&
         without_drift.shared < kReliefStill * refined.shared;
}

// A joint refinement on its way from the starting poses.
class Refining {
 public:
  Refining(const std::vector<ViewSurface>& surfaces, const std::vector<RigidMotion>& start,
           const std::vector<ViewRole>& roles, const JointRefinementOptions& options,
           const Progress& progress)
      : surfaces_(surfaces), start_(start), roles_(roles), options_(options), progress_(progress) {
    result_.world_from_view = start;
    unlink_views();
    result_.held = hold_one_per_group(result_.group, roles);
    result_.pose_covariance.assign(surfaces.size(), Matrix6d::Zero());
    result_.pose_std.assign(surfaces.size(), RigidTangent::Zero());
  }

  Result<JointRefinement> run() {
    const bool any_samples = std::any_of(surfaces_.begin(), surfaces_.end(), [](const auto& s) {
      return !s.samples().empty() && s.spacing() > 0.0;
    });
    if (!any_samples) return std::move(result_);
    plan_ = plan_search(surfaces_, start_, roles_, options_);
    for (std::size_t l = 0; l < plan_.levels.size(); ++l) {
      link_views(plan_.levels[l]);
      if (pairs_.empty()) break;
      if (!refine_at(l)) return interrupted();
      if (result_.termination == RefinementTermination::kSolverFailed) return std::move(result_);
    }
    if (pairs_.empty()) {
      result_.termination = RefinementTermination::kNoOverlap;
      unlink_views();
      return std::move(result_);
    }
    release_freed_memory();  // What solving took; the last steps grow as large.
    if (!report_progress(progress_, 0.0, "computing covariances")) return interrupted();
    const RefinementTermination of_levels = result_.termination;
    finish({}, kFirstLastSteps);
    auto drifting =
        degenerate_groups(shared_, surfaces_, result_.world_from_view, result_.group, result_.held);
    std::erase_if(drifting, [&](const auto& group) { return held_by_maps(group, result_.pairs); });
    if (!drifting.empty() && finish_without_drift(drifting)) return std::move(result_);
    if (result_.termination == RefinementTermination::kIterationLimit &&
        result_.last_motion > plan_.levels.back().tolerance) {
      const JointRefinement before = result_;
      result_.termination = of_levels;
      finish({}, kMostLastSteps);
      if (result_.termination == RefinementTermination::kSolverFailed) result_ = before;
    }
    return std::move(result_);
  }

 private:
  static Error interrupted() { return {ErrorKind::kInterrupted, "alignment was interrupted"}; }

  void unlink_views() { result_.group = connected_groups(surfaces_.size(), {}); }

  void link_views(const SearchLevel& level) {
    pairs_ = pairs_at(surfaces_, result_.world_from_view, roles_, level, options_);
    if (pairs_.empty()) return;
    result_.group = connected_groups(surfaces_.size(), pairs_);
    result_.held = hold_one_per_group(result_.group, roles_);
  }

  // Renews the correspondences of a level until the poses stand still. False: interrupted.
  bool refine_at(std::size_t l) {
    const SearchLevel& level = plan_.levels[l];
    result_.termination = RefinementTermination::kIterationLimit;
    const auto strongest = largest_overlaps(surfaces_.size(), pairs_, kMostPairsOfAView);
    for (int i = 0; i < options_.max_iterations; ++i) {
      const double fraction =
          (l + static_cast<double>(i) / options_.max_iterations) / plan_.levels.size();
      if (!report_progress(progress_, fraction, "refining poses")) return false;
      const PairMatcher match(surfaces_, result_.world_from_view, strongest,
                              search_at(level, strongest.size(), kFewestTogether, options_),
                              level.signal_level, plan_.nearly_degenerate);
      const auto before = result_.world_from_view;
      result_.solves.push_back(
          solve_poses(surfaces_, match.size(), match, result_.held, {}, result_.world_from_view));
      if (result_.solves.back().termination == SolverTermination::kFailed) {
        result_.termination = RefinementTermination::kSolverFailed;
        return true;
      }
      ++result_.iterations;
      result_.last_motion = largest_motion(pointers_to(surfaces_), before, result_.world_from_view);
      if (result_.last_motion <= level.tolerance) {
        result_.termination = RefinementTermination::kConverged;
        return true;
      }
    }
    return true;
  }

  void finish(MotionsOfViews kept_motions, int most_steps) {
    shared_ = take_last_steps(
        surfaces_, {pairs_, largest_overlaps(surfaces_.size(), pairs_, kMostPairsOfAView)},
        plan_.levels.back(), plan_.nearly_degenerate, std::move(kept_motions), most_steps, options_,
        result_);
  }

  // A drift along degenerate directions leaves the fit as it is. A large one may have led to where
  // these are others than at the start: then the views go back all the way. False: the views stay,
  // since relief that they share brought them here.
  bool finish_without_drift(const std::vector<DegenerateGroup>& drifting) {
    const JointRefinement refined = result_;
    const std::vector<ViewPair> pairs = pairs_;
    const MotionConstraint relief = constraint_along_motions(drifting, shared_);
    finish_without(Drift::kAlongMotions, drifting);
    if (loses_relief(constraint_along_motions(drifting, shared_), relief)) {
      result_ = refined;
      pairs_ = pairs;
      return false;
    }
    if (fits_as_well(result_, refined)) return true;
    JointRefinement along_motions = std::exchange(result_, refined);
    finish_without(Drift::kAll, drifting);
    if (total_overlap(result_) < total_overlap(along_motions)) result_ = std::move(along_motions);
    return true;
  }

  void finish_without(Drift drift, const std::vector<DegenerateGroup>& drifting) {
    auto kept_motions = remove_drift(drifting, drift, surfaces_, start_, result_.world_from_view);
    link_views(plan_.levels.back());
    if (!pairs_.empty()) finish(std::move(kept_motions), kFirstLastSteps);
  }

  const std::vector<ViewSurface>& surfaces_;
  const std::vector<RigidMotion>& start_;
  const std::vector<ViewRole>& roles_;
  const JointRefinementOptions& options_;
  const Progress& progress_;
  SearchPlan plan_;
  std::vector<ViewPair> pairs_;         // At the present poses.
  std::vector<PairConstraint> shared_;  // What pairs share after the last steps.
  JointRefinement result_;
};

}  // namespace

Result<JointRefinement> refine_jointly(const std::vector<ViewSurface>& surfaces,
                                       const std::vector<RigidMotion>& world_from_view,
                                       const std::vector<ViewRole>& roles,
                                       const JointRefinementOptions& options,
                                       const Progress& progress) {
  assert(surfaces.size() == world_from_view.size() && surfaces.size() == roles.size());
  return Refining(surfaces, world_from_view, roles, options, progress).run();
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
