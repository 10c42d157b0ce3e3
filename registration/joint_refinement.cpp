#include "registration/joint_refinement.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "registration/dense_refinement.h"
#include "registration/joint_solver.h"
#include "registration/robust.h"
#include "registration/search_schedule.h"
#include "registration/view_graph.h"
#include "scan/parallel.h"

namespace relief {

namespace {

constexpr double kSearchRadii = 0.2;
// Of all pairs at a time, some two thirds of a kilobyte each; and of one direction of a pair.
constexpr std::size_t kMostCorrespondences = 250'000;
constexpr std::size_t kFewestCorrespondences = 60;
// All pairs of hundreds of views would get so few each, and still need gigabytes. The last steps,
// which keep nothing for a residual, use all.
constexpr int kMostPairsOfAView = 24;
// Pairs that share fewer samples or less of the views than this are thin.
constexpr double kThinSamples = 200.0;
constexpr double kThinOverlap = 0.1;
// The last steps are precise enough to stop at less than the levels before them.
constexpr double kFinalTolerance = 0.5;
// Residuals of all pairs together in the last step: some ten seconds of processor time.
constexpr std::size_t kMostLastResiduals = 50'000'000;

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

// Hundreds of views have thousands of pairs: each then needs fewer, for the same number per view.
int correspondences_per_direction(const SearchLevel& level, std::size_t pairs) {
  const std::size_t share = kMostCorrespondences / std::max<std::size_t>(1, 2 * pairs);
  return std::min(level.count, static_cast<int>(std::max(share, kFewestCorrespondences)));
}

double slip_threshold(const ViewSurface& a, const ViewSurface& b) {
  return stiffness_threshold(std::max(a.normal_noise(), b.normal_noise()));
}

Stability stability_of(const Correspondences& found) {
  std::vector<OrientedPoint> points;
  points.reserve(found.items.size());
  for (const auto& c : found.items) points.push_back({c.target.point, c.target.normal});
  return analyse_stability(points);
}

// The normal maps at the correspondences of a directed pair, without an opinion on motions that
// neither they nor geometry determine.
NormalMatches normals_of(const std::vector<ViewSurface>& surfaces, const DirectedMatches& directed,
                         const RigidMotion& target_from_source, int signal_level) {
  const ViewSurface &source = surfaces[directed.source], &target = surfaces[directed.target];
  auto normals = match_normals(source, target, target_from_source, directed.found, signal_level);
  if (normals.items.empty()) return normals;
  const double threshold = slip_threshold(source, target);
  const Stability stability =
      with_normal_maps(stability_of(directed.found), normals,
                       directed.found.sigma / normals.effective_sigma, threshold);
  for (const auto& free : degenerate_directions(stability, threshold))
    ignore_motion(free.motion, free.centre, normals);
  return normals;
}

CorrespondenceOptions search_at(const SearchLevel& level, std::size_t pairs,
                                const JointRefinementOptions& options) {
  CorrespondenceOptions search;
  search.count = correspondences_per_direction(level, pairs);
  search.max_distance = level.max_distance;
  search.max_normal_angle_deg = options.max_normal_angle_deg;
  search.association = options.association;
  return search;
}

// Directed pair i of the pairs: (a, b) at 2k, (b, a) at 2k + 1. The normal maps are matched where
// either view is `sliding`.
class Matcher {
 public:
  Matcher(const std::vector<ViewSurface>& surfaces, const std::vector<RigidMotion>& world_from_view,
          const std::vector<ViewPair>& pairs, const SearchLevel& level,
          const JointRefinementOptions& options, const std::vector<bool>& sliding)
      : surfaces_(surfaces),
        world_from_view_(world_from_view),
        pairs_(pairs),
        signal_level_(level.signal_level),
        search_(search_at(level, pairs.size(), options)),
        sliding_(sliding) {}

  std::size_t size() const { return 2 * pairs_.size(); }
  bool by_normal_maps(std::size_t i) const {
    return sliding_[pairs_[i / 2].a] || sliding_[pairs_[i / 2].b];
  }

  DirectedMatches operator()(std::size_t i) const {
    const ViewPair& pair = pairs_[i / 2];
    DirectedMatches directed;
    directed.source = i % 2 == 0 ? pair.a : pair.b;
    directed.target = i % 2 == 0 ? pair.b : pair.a;
    const RigidMotion target_from_source =
        world_from_view_[directed.target].inverse() * world_from_view_[directed.source];
    directed.found = find_correspondences(surfaces_[directed.source], surfaces_[directed.target],
                                          target_from_source, search_);
    if (by_normal_maps(i))
      directed.normals = normals_of(surfaces_, directed, target_from_source, signal_level_);
    return directed;
  }

 private:
  const std::vector<ViewSurface>& surfaces_;
  const std::vector<RigidMotion>& world_from_view_;
  const std::vector<ViewPair>& pairs_;
  int signal_level_;
  CorrespondenceOptions search_;
  const std::vector<bool>& sliding_;
};

template <typename Value, typename Compute>
std::vector<Value> for_all(std::size_t count, int threads, const Compute& compute) {
  std::vector<Value> values(count);
  parallel_for(count, 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) values[i] = compute(i);
  });
  return values;
}

// Views that all their correspondences together hardly hold, and that have normal maps: geometry
// that holds a view well needs no help from maps, whose errors are less well known.
std::vector<bool> sliding_views(const std::vector<ViewSurface>& surfaces,
                                const std::vector<RigidMotion>& world_from_view,
                                const std::vector<DirectedMatches>& matches) {
  std::vector<std::vector<OrientedPoint>> points(surfaces.size());
  for (const auto& directed : matches) {
    const RigidMotion& pose = world_from_view[directed.target];
    for (const auto& c : directed.found.items)
      for (const std::size_t view : {directed.source, directed.target})
        points[view].push_back({pose * c.target.point, pose.linear() * c.target.normal});
  }
  std::vector<bool> sliding(surfaces.size());
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    sliding[i] = surfaces[i].signal_levels() > 0 && !points[i].empty() &&
                 slides_nearly(analyse_stability(points[i]),
                               stiffness_threshold(surfaces[i].normal_noise()));
  return sliding;
}

// How to search, coarse to fine, and for which views by normal maps too.
struct SearchPlan {
  std::vector<SearchLevel> levels;
  std::vector<bool> sliding;
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
  const Matcher match(surfaces, world_from_view, pairs, plan.levels.front(), options, plan.sliding);
  const auto matches = for_all<DirectedMatches>(match.size(), options.threads, match);
  plan.sliding = sliding_views(surfaces, world_from_view, matches);
  if (std::find(plan.sliding.begin(), plan.sliding.end(), true) != plan.sliding.end())
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

PairFit fit_of(const std::vector<ViewSurface>& surfaces,
               const std::vector<RigidMotion>& world_from_view, const DirectedMatches& forward,
               const DirectedMatches& backward) {
  PairFit fit;
  fit.a = forward.source;
  fit.b = forward.target;
  fit.overlap = 0.5 * (forward.found.overlap() + backward.found.overlap());
  std::vector<OrientedPoint> points;
  NormalMatches normals;
  double squares = 0.0;
  for (const auto* directed : {&forward, &backward}) {
    const RigidMotion& pose = world_from_view[directed->target];
    for (const auto& c : directed->found.items) {
      squares += c.distance * c.distance;
      points.push_back({pose * c.target.point, pose.linear() * c.target.normal});
    }
    for (const auto& match : directed->normals.items) normals.items.push_back(match.moved(pose));
    normals.effective_sigma = std::max(normals.effective_sigma, directed->normals.effective_sigma);
    normals.redundancy = std::max(normals.redundancy, directed->normals.redundancy);
  }
  fit.correspondences = points.size();
  if (!points.empty()) fit.rms = std::sqrt(squares / static_cast<double>(points.size()));
  const double threshold = slip_threshold(surfaces[fit.a], surfaces[fit.b]);
  Stability stability = analyse_stability(points);
  if (!normals.items.empty())
    stability = with_normal_maps(
        stability, normals,
        std::max(forward.found.sigma, backward.found.sigma) / normals.effective_sigma, threshold);
  fit.normal_maps = !normals.items.empty();
  fit.degenerate_directions = degenerate_directions(stability, threshold);
  return fit;
}

// In the order of what matters most about a pair.
PairGrade grade_of(const PairFit& fit, double shared_samples, double largest_rms) {
  if (fit.rms > largest_rms) return PairGrade::kMisfit;
  if (fit.overlap < kThinOverlap || shared_samples < kThinSamples) return PairGrade::kThin;
  return fit.degenerate_directions.empty() ? PairGrade::kFirm : PairGrade::kSlides;
}

void grade_pairs(const std::vector<ViewSurface>& surfaces, std::vector<PairFit>& pairs) {
  const auto limits = largest_fitting_rms(surfaces, pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    PairFit& fit = pairs[i];
    const std::size_t samples =
        std::min(surfaces[fit.a].samples().size(), surfaces[fit.b].samples().size());
    fit.grade = grade_of(fit, fit.overlap * static_cast<double>(samples), limits[i]);
  }
}

// Pair by pair: all matches of hundreds of views would need more memory than all else.
void describe_fit(const Matcher& match, const std::vector<ViewSurface>& surfaces, int threads,
                  JointRefinement& result) {
  result.pairs = for_all<PairFit>(match.size() / 2, threads, [&](std::size_t k) {
    return fit_of(surfaces, result.world_from_view, match(2 * k), match(2 * k + 1));
  });
  double squares = 0.0;
  std::size_t count = 0;
  for (const PairFit& fit : result.pairs) {
    squares += fit.rms * fit.rms * static_cast<double>(fit.correspondences);
    count += fit.correspondences;
  }
  grade_pairs(surfaces, result.pairs);
  if (count > 0) result.rms = std::sqrt(squares / static_cast<double>(count));
}

std::size_t last_samples(const JointRefinementOptions& options, std::size_t pairs) {
  const std::size_t share = std::max<std::size_t>(1000, kMostLastResiduals / (2 * pairs));
  const auto wanted = static_cast<std::size_t>(options.final_samples);
  return wanted == 0 ? share : std::min(wanted, share);
}

// The last steps, with all samples; gives the covariance too.
void finish(const std::vector<ViewSurface>& surfaces, const std::vector<ViewPair>& pairs,
            const SearchLevel& level, const std::vector<bool>& sliding,
            const JointRefinementOptions& options, JointRefinement& result) {
  DenseRefinementOptions dense;
  dense.search = search_at(level, pairs.size(), options);
  dense.last_samples = last_samples(options, pairs.size());
  dense.step_samples = std::min(dense.step_samples, dense.last_samples);
  dense.tolerance = kFinalTolerance * level.tolerance;
  dense.threads = options.threads;
  if (std::find(sliding.begin(), sliding.end(), true) != sliding.end()) {
    const Matcher match(surfaces, result.world_from_view, pairs, level, options, sliding);
    dense.normals = for_all<NormalMatches>(match.size(), options.threads, [&](std::size_t i) {
      return match.by_normal_maps(i) ? match(i).normals : NormalMatches();
    });
  }
  const auto refined =
      refine_densely(pointers_to(surfaces), pairs, result.held, dense, result.world_from_view);
  result.iterations += refined.iterations;
  result.last_motion = refined.last_motion;
  if (refined.last_motion > level.tolerance)
    result.termination = RefinementTermination::kIterationLimit;
  result.pose_covariance = refined.covariance;
  const Eigen::VectorXd variance = refined.covariance.diagonal();
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    result.pose_std[i] =
        variance.segment<6>(static_cast<Eigen::Index>(6 * i)).cwiseMax(0.0).cwiseSqrt();
}

}  // namespace

std::vector<double> largest_fitting_rms(const std::vector<ViewSurface>& surfaces,
                                        const std::vector<PairFit>& pairs) {
  // A pair that deviates by this many times the median of all pairs is uncommon.
  constexpr double kCommonRms = 2.0;
  std::vector<double> all, limits;
  for (const auto& pair : pairs) all.push_back(pair.rms);
  const double common = kCommonRms * quantile(all, 0.5);
  for (const auto& pair : pairs) {
    const ViewSurface &a = surfaces[pair.a], &b = surfaces[pair.b];
    limits.push_back(std::max(common, largest_plausible_rms(std::max(a.spacing(), b.spacing()),
                                                            std::hypot(a.noise(), b.noise()))));
  }
  return limits;
}

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
  const auto size = static_cast<Eigen::Index>(6 * surfaces.size());
  result.pose_covariance = Eigen::MatrixXd::Zero(size, size);
  const bool any_samples = std::any_of(surfaces.begin(), surfaces.end(), [](const auto& s) {
    return !s.samples().empty() && s.spacing() > 0.0;
  });
  if (!any_samples) return result;

  const auto [levels, sliding] = plan_search(surfaces, world_from_view, roles, options);
  std::vector<ViewPair> pairs;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    pairs = pairs_at(surfaces, result.world_from_view, roles, levels[l], options);
    if (pairs.empty()) break;
    result.group = connected_groups(surfaces.size(), pairs);
    result.held = hold_one_per_group(result.group, roles);
    result.termination = RefinementTermination::kIterationLimit;
    const auto strongest = largest_overlaps(surfaces.size(), pairs, kMostPairsOfAView);
    for (int i = 0; i < options.max_iterations; ++i) {
      const double fraction = (l + static_cast<double>(i) / options.max_iterations) / levels.size();
      if (!report_progress(progress, fraction, "refining poses"))
        return Error{ErrorKind::kInterrupted, "alignment was interrupted"};
      const Matcher match(surfaces, result.world_from_view, strongest, levels[l], options, sliding);
      const auto matches = for_all<DirectedMatches>(match.size(), options.threads, match);
      const auto before = result.world_from_view;
      solve_poses(surfaces, matches, result.held, {}, result.world_from_view);
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
  finish(surfaces, pairs, levels.back(), sliding, options, result);
  describe_fit(Matcher(surfaces, result.world_from_view, pairs, levels.back(), options, sliding),
               surfaces, options.threads, result);
  return result;
}

std::string_view to_string(PairGrade grade) {
  switch (grade) {
    case PairGrade::kFirm:
      return "firm";
    case PairGrade::kSlides:
      return "slides";
    case PairGrade::kThin:
      return "thin";
    case PairGrade::kMisfit:
      return "misfit";
  }
  return "unknown";
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
