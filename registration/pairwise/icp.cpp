#include "registration/pairwise/icp.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <Eigen/Dense>

#include "registration/pairwise/plane_step.h"
#include "registration/pairwise/robust.h"
#include "registration/pairwise/search_schedule.h"
#include "registration/posegraph/refinement/pose_graph_refinement.h"
#include "relief/scan/context.h"
#include "scan/base/robust_scales.h"

namespace relief::registration {

namespace {

// Correspondences that tell the deviation of a direction to 4 percent (1.17 / sqrt(n)).
constexpr int kDeviationSamples = 1000;

struct Matches {
  std::vector<PlanePair> pairs;  // In the target frame.
  NormalTerms normals;           // In the target frame.
  double overlap = 0.0;
  double rms = 0.0;
};

// The normal maps at the correspondences of both directions.
NormalTerms match_normals_both_ways(const ViewSurface& source, const ViewSurface& target,
                                    const RigidMotion& target_from_source,
                                    const Correspondences& forward, const Correspondences& backward,
                                    int level) {
  NormalTerms terms;
  terms.matches = match_normals(source, target, target_from_source, forward, level);
  const auto others = match_normals(target, source, target_from_source.inverse(), backward, level);
  for (const NormalMatch& match : others.items)
    terms.matches.items.push_back(match.moved(target_from_source).reversed());
  terms.matches.sigma = std::max(terms.matches.sigma, others.sigma);
  terms.matches.redundancy = std::max(terms.matches.redundancy, others.redundancy);
  terms.matches.effective_sigma = std::max(terms.matches.effective_sigma, others.effective_sigma);
  if (!terms.matches.items.empty())
    terms.length_per_angle =
        std::max(forward.sigma, backward.sigma) / terms.matches.effective_sigma;
  return terms;
}

// Counterparts of the samples of both views, all in the target's frame.
Matches match_both_ways(const ViewSurface& source, const ViewSurface& target,
                        const RigidMotion& target_from_source, const CorrespondenceOptions& options,
                        int signal_level) {
  const auto forward = find_correspondences(source, target, target_from_source, options);
  const auto backward = find_correspondences(target, source, target_from_source.inverse(), options);
  const Eigen::Matrix3d rotation = target_from_source.linear();
  Matches matches;
  matches.overlap = 0.5 * (forward.overlap() + backward.overlap());
  double squares = 0.0;
  const auto add = [&](const SurfacePoint& of_source, const SurfacePoint& of_target,
                       const Correspondence& c, double sigma, bool normal_of_target) {
    PlanePair pair{target_from_source * of_source.point,
                   of_target.point,
                   rotation * of_source.normal,
                   of_target.normal,
                   of_target.normal,
                   c.weight};
    if (!normal_of_target) pair.normal = pair.moving_normal;
    pair.weight *= cauchy_weight(c.distance / sigma, kCauchyScale);
    squares += c.distance * c.distance;
    matches.pairs.push_back(pair);
  };
  for (const auto& c : forward.items) add(c.source, c.target, c, forward.sigma, true);
  for (const auto& c : backward.items) add(c.target, c.source, c, backward.sigma, false);
  if (signal_level >= 0)
    matches.normals = match_normals_both_ways(source, target, target_from_source, forward, backward,
                                              signal_level);
  if (!matches.pairs.empty())
    matches.rms = std::sqrt(squares / static_cast<double>(matches.pairs.size()));
  return matches;
}

std::vector<SearchLevel> levels_for(const ViewSurface& source, const ViewSurface& target,
                                    const IcpOptions& options, int signal_levels) {
  const double spacing = std::max(source.spacing(), target.spacing());
  const double noise = std::hypot(source.noise(), target.noise());
  SearchScheduleOptions schedule;
  schedule.levels = options.levels;
  schedule.signal_levels = signal_levels;
  schedule.correspondences = options.correspondences;
  schedule.first_distance = options.search_distance > 0.0
                                ? options.search_distance
                                : kFirstSearchRadii * std::min(source.radius(), target.radius());
  schedule.last_distance = finest_search_distance(spacing, noise);
  schedule.tolerance = options.tolerance * std::min(source.spacing(), target.spacing());
  return search_schedule(schedule);
}

CorrespondenceOptions search_at(const SearchLevel& level, const IcpOptions& options) {
  CorrespondenceOptions search;
  search.count = level.count;
  search.max_distance = level.max_distance;
  search.max_normal_angle_deg = options.max_normal_angle_deg;
  search.association = options.association;
  return search;
}

// Resolutions of the normal maps to align: none where geometry holds the pair.
int signal_levels_for(const ViewSurface& source, const ViewSurface& target,
                      const RigidMotion& target_from_source, const IcpOptions& options,
                      double threshold) {
  const int levels = std::min(source.signal_levels(), target.signal_levels());
  if (!options.normal_maps || levels == 0) return 0;
  const auto first = levels_for(source, target, options, 0).front();
  const auto matches =
      match_both_ways(source, target, target_from_source, search_at(first, options), -1);
  return is_nearly_degenerate(analyse_constraints(matches.pairs), threshold) ? levels : 0;
}

// Brings one view to another.
class PairAlignment {
 public:
  PairAlignment(const ViewSurface& source, const ViewSurface& target,
                const RigidMotion& target_from_source, const IcpOptions& options)
      : source_(source),
        target_(target),
        options_(options),
        threshold_(eigenvalue_threshold(std::max(source.normal_noise(), target.normal_noise()))),
        signal_levels_(signal_levels_for(source, target, target_from_source, options, threshold_)) {
    result_.target_from_source = target_from_source;
  }

  IcpResult run() {
    const auto levels = levels_for(source_, target_, options_, signal_levels_);
    for (const SearchLevel& level : levels) {
      iterate(level);
      if (!result_.usable()) return result_;
    }
    result_.degenerate_directions = degenerate_directions(spectrum_, threshold_);
    if (options_.final_samples > 0) finish(levels.back());
    return result_;
  }

 private:
  // Renews the correspondences until the pose stands still.
  void iterate(const SearchLevel& level) {
    const CorrespondenceOptions search = search_at(level, options_);
    result_.termination = IcpTermination::kIterationLimit;
    for (int i = 0; i < options_.max_iterations; ++i) {
      const Matches matches = match_both_ways(source_, target_, result_.target_from_source, search,
                                              signal_levels_ > 0 ? level.signal_level : -1);
      result_.correspondences = matches.pairs.size();
      result_.overlap = matches.overlap;
      result_.rms = matches.rms;
      result_.normal_sigma = matches.normals.matches.sigma;
      if (matches.pairs.size() < static_cast<std::size_t>(options_.min_correspondences)) {
        result_.termination = IcpTermination::kNoOverlap;
        return;
      }
      const PlaneStep step =
          solve_plane_step(matches.pairs, matches.normals, options_.objective, threshold_);
      spectrum_ = step.spectrum;
      const double motion = largest_motion(step.motion, source_, result_.target_from_source);
      result_.target_from_source = step.motion * result_.target_from_source;
      ++result_.iterations;
      if (motion < level.tolerance) {
        result_.termination = IcpTermination::kConverged;
        return;
      }
    }
  }

  // The last steps of the joint refinement, of two views the second of which is held.
  void finish(const SearchLevel& level) {
    PoseGraphRefinementOptions last;
    last.search = search_at(level, options_);
    last.search.count = std::min(last.search.count, kDeviationSamples);
    last.last_samples = static_cast<std::size_t>(options_.final_samples);
    last.step_samples = last.last_samples / 4 + 1;
    last.max_iterations = 1;
    last.degenerate_directions = result_.degenerate_directions;
    std::vector<RigidMotion> poses = {result_.target_from_source, RigidMotion::Identity()};
    if (signal_levels_ > 0) {
      for (const bool forward : {true, false}) {
        const ViewSurface &from = forward ? source_ : target_, &to = forward ? target_ : source_;
        const RigidMotion to_from_from = forward ? poses[0] : poses[0].inverse();
        const auto found = find_correspondences(from, to, to_from_from, search_at(level, options_));
        last.normals.add(match_normals(from, to, to_from_from, found, level.signal_level));
      }
    }
    // Pairs are aligned side by side, so the two directions of one need no threads.
    const auto refined = on_threads(1, [&] {
      return refine_pose_graph({&source_, &target_}, {{0, 1}}, {false, true}, last, poses);
    });
    result_.iterations += refined.iterations;
    result_.target_from_source = poses[0];
    result_.covariance = refined.covariance.of(0);
    result_.covariance_centre = poses[0] * source_.centre();
  }

  const ViewSurface &source_, &target_;
  const IcpOptions& options_;
  double threshold_;
  int signal_levels_;
  ConstraintSpectrum spectrum_;
  IcpResult result_;
};

}  // namespace

IcpResult align_pair(const ViewSurface& source, const ViewSurface& target,
                     const RigidMotion& target_from_source, const IcpOptions& options) {
  assert(options.min_correspondences >= 6 && options.levels >= 1 && options.final_samples >= 0);
  if (!source.samples().empty() && !target.samples().empty() &&
      std::max(source.spacing(), target.spacing()) > 0.0)
    return PairAlignment(source, target, target_from_source, options).run();
  IcpResult result;
  result.target_from_source = target_from_source;
  return result;
}

IcpResult align_pair(const RangeView& source, const RangeView& target,
                     const RigidMotion& target_from_source, const IcpOptions& options) {
  const ViewSurfaceOptions surface{.neighbour_index = options.association == Association::kNearest};
  return align_pair(ViewSurface(source, surface), ViewSurface(target, surface), target_from_source,
                    options);
}

std::string_view to_string(IcpTermination termination) {
  switch (termination) {
    case IcpTermination::kConverged:
      return "converged";
    case IcpTermination::kIterationLimit:
      return "iteration limit";
    case IcpTermination::kNoOverlap:
      return "no overlap";
  }
  return "unknown";
}

}  // namespace relief::registration
