#include "registration/joint_refinement.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "registration/joint_solver.h"
#include "registration/robust.h"
#include "registration/search_schedule.h"
#include "registration/view_graph.h"
#include "scan/parallel.h"

namespace relief {

namespace {

constexpr double kSearchRadii = 0.2;

std::vector<SearchLevel> levels_for(const std::vector<ViewSurface>& surfaces,
                                    const JointRefinementOptions& options) {
  std::vector<double> spacings, noises, radii;
  for (const auto& surface : surfaces) {
    if (surface.samples().empty()) continue;
    spacings.push_back(surface.spacing());
    noises.push_back(surface.noise());
    radii.push_back(surface.radius());
  }
  SearchScheduleOptions schedule;
  schedule.levels = options.levels;
  schedule.correspondences = options.correspondences;
  schedule.first_distance =
      options.search_distance > 0.0 ? options.search_distance : kSearchRadii * quantile(radii, 0.5);
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
  graph.threads = options.threads;
  auto pairs = find_overlapping_pairs(surfaces, world_from_view, graph);
  std::erase_if(pairs, [&](const ViewPair& pair) {
    return roles[pair.a] == ViewRole::kExcluded || roles[pair.b] == ViewRole::kExcluded;
  });
  return pairs;
}

// Both directions of every pair: (a, b) at 2k, (b, a) at 2k + 1.
std::vector<DirectedMatches> match(const std::vector<ViewSurface>& surfaces,
                                   const std::vector<RigidMotion>& world_from_view,
                                   const std::vector<ViewPair>& pairs, const SearchLevel& level,
                                   const JointRefinementOptions& options) {
  CorrespondenceOptions search;
  search.count = level.count;
  search.max_distance = level.max_distance;
  search.max_normal_angle_deg = options.max_normal_angle_deg;
  search.association = options.association;
  std::vector<DirectedMatches> matches(2 * pairs.size());
  parallel_for(matches.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      DirectedMatches& directed = matches[i];
      directed.source = i % 2 == 0 ? pairs[i / 2].a : pairs[i / 2].b;
      directed.target = i % 2 == 0 ? pairs[i / 2].b : pairs[i / 2].a;
      const RigidMotion target_from_source =
          world_from_view[directed.target].inverse() * world_from_view[directed.source];
      directed.found = find_correspondences(surfaces[directed.source], surfaces[directed.target],
                                            target_from_source, search);
    }
  });
  return matches;
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

double largest_motion(const std::vector<ViewSurface>& surfaces,
                      const std::vector<RigidMotion>& before,
                      const std::vector<RigidMotion>& after) {
  double largest = 0.0;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Eigen::Vector3d centre = surfaces[i].centre();
    const double turn = rotation_angle(after[i] * before[i].inverse());
    largest = std::max(
        largest, (after[i] * centre - before[i] * centre).norm() + turn * surfaces[i].radius());
  }
  return largest;
}

PairFit fit_of(const std::vector<ViewSurface>& surfaces,
               const std::vector<RigidMotion>& world_from_view, const DirectedMatches& forward,
               const DirectedMatches& backward) {
  PairFit fit;
  fit.a = forward.source;
  fit.b = forward.target;
  fit.overlap = 0.5 * (forward.found.overlap() + backward.found.overlap());
  std::vector<OrientedPoint> points;
  double squares = 0.0;
  for (const auto* directed : {&forward, &backward}) {
    const RigidMotion& pose = world_from_view[directed->target];
    for (const auto& c : directed->found.items) {
      squares += c.distance * c.distance;
      points.push_back({pose * c.target.point, pose.linear() * c.target.normal});
    }
  }
  fit.correspondences = points.size();
  if (!points.empty()) fit.rms = std::sqrt(squares / static_cast<double>(points.size()));
  const double noise = std::max(surfaces[fit.a].normal_noise(), surfaces[fit.b].normal_noise());
  fit.degenerate_directions =
      degenerate_directions(analyse_stability(points), stiffness_threshold(noise));
  return fit;
}

void describe_fit(const std::vector<ViewSurface>& surfaces,
                  const std::vector<DirectedMatches>& matches, JointRefinement& result) {
  double squares = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + 1 < matches.size(); i += 2) {
    result.pairs.push_back(fit_of(surfaces, result.world_from_view, matches[i], matches[i + 1]));
    const PairFit& fit = result.pairs.back();
    squares += fit.rms * fit.rms * static_cast<double>(fit.correspondences);
    count += fit.correspondences;
  }
  if (count > 0) result.rms = std::sqrt(squares / static_cast<double>(count));
  result.pose_std = pose_deviations(surfaces, matches, result.held, result.world_from_view);
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
  result.pose_std.assign(surfaces.size(), RigidTangent::Zero());
  const bool any_samples = std::any_of(surfaces.begin(), surfaces.end(),
                                       [](const auto& s) { return !s.samples().empty(); });
  if (!any_samples) return result;

  const auto levels = levels_for(surfaces, options);
  std::vector<ViewPair> pairs;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    pairs = pairs_at(surfaces, result.world_from_view, roles, levels[l], options);
    if (pairs.empty()) break;
    result.group = connected_groups(surfaces.size(), pairs);
    result.held = hold_one_per_group(result.group, roles);
    result.termination = RefinementTermination::kIterationLimit;
    for (int i = 0; i < options.max_iterations; ++i) {
      const double fraction = (l + static_cast<double>(i) / options.max_iterations) / levels.size();
      if (!report_progress(progress, fraction, "refining poses"))
        return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
      const auto matches = match(surfaces, result.world_from_view, pairs, levels[l], options);
      const auto before = result.world_from_view;
      solve_poses(surfaces, matches, result.held, {}, result.world_from_view);
      ++result.iterations;
      result.last_motion = largest_motion(surfaces, before, result.world_from_view);
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
  describe_fit(surfaces, match(surfaces, result.world_from_view, pairs, levels.back(), options),
               result);
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
  }
  return "unknown";
}

}  // namespace relief
