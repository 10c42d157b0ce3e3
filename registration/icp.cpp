#include "registration/icp.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <Eigen/Dense>

#include "registration/plane_step.h"
#include "registration/robust.h"
#include "registration/search_schedule.h"

namespace relief {

namespace {

constexpr double kSearchRadii = 0.2;

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
                                : kSearchRadii * std::min(source.radius(), target.radius());
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
  return slides_nearly(analyse_stability(matches.pairs), threshold) ? levels : 0;
}

// How far `step` (in the target's frame) moves a point of the source at most.
double largest_motion(const RigidMotion& step, const ViewSurface& source,
                      const RigidMotion& target_from_source) {
  const Eigen::Vector3d centre = target_from_source * source.centre();
  return (step * centre - centre).norm() + rotation_angle(step) * source.radius();
}

void describe_solution(const PlaneStep& step, double rms, double threshold, IcpResult& result) {
  result.degenerate_directions = degenerate_directions(step.stability, threshold);
  result.covariance_centre = step.stability.centre;
  // A prior of one radian and one radius keeps directions without information finite.
  Vector6d prior = Vector6d::Ones();
  prior.tail<3>() /= step.stability.radius * step.stability.radius;
  const double variance = rms * rms;
  Matrix6d information = variance * prior.asDiagonal().toDenseMatrix() + step.information;
  result.covariance = variance * information.inverse();
}

}  // namespace

IcpResult align_pair(const ViewSurface& source, const ViewSurface& target,
                     const RigidMotion& target_from_source, const IcpOptions& options) {
  assert(options.min_correspondences >= 6 && options.levels >= 1);
  IcpResult result;
  result.target_from_source = target_from_source;
  if (source.samples().empty() || target.samples().empty()) return result;
  if (!(std::max(source.spacing(), target.spacing()) > 0.0)) return result;
  const double threshold =
      stiffness_threshold(std::max(source.normal_noise(), target.normal_noise()));
  const int signal_levels =
      signal_levels_for(source, target, target_from_source, options, threshold);
  PlaneStep step;
  for (const SearchLevel& level : levels_for(source, target, options, signal_levels)) {
    const CorrespondenceOptions search = search_at(level, options);
    result.termination = IcpTermination::kIterationLimit;
    for (int i = 0; i < options.max_iterations; ++i) {
      const Matches matches = match_both_ways(source, target, result.target_from_source, search,
                                              signal_levels > 0 ? level.signal_level : -1);
      result.correspondences = matches.pairs.size();
      result.overlap = matches.overlap;
      result.rms = matches.rms;
      if (matches.pairs.size() < static_cast<std::size_t>(options.min_correspondences)) {
        result.termination = IcpTermination::kNoOverlap;
        return result;
      }
      result.normal_sigma = matches.normals.matches.sigma;
      step = solve_plane_step(matches.pairs, matches.normals, options.objective, threshold);
      const double motion = largest_motion(step.motion, source, result.target_from_source);
      result.target_from_source = step.motion * result.target_from_source;
      ++result.iterations;
      if (motion < level.tolerance) {
        result.termination = IcpTermination::kConverged;
        break;
      }
    }
  }
  describe_solution(step, result.rms, threshold, result);
  return result;
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

}  // namespace relief
