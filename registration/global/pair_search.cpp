#include "registration/global/pair_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "registration/global/features/feature_matches.h"
#include "registration/global/links/consistency_graph.h"
#include "registration/global/robust_motion.h"
#include "registration/pairwise/icp.h"

namespace relief::registration {

namespace {

// Lengths in cells. With the numbers of this file `relief_coarse_runs` places no view of 200
// difficult scenes wrongly (docs/results.md, Global registration).
// Discs of these radii hold 28 and 113 points (pi r^2).
constexpr double kSmallFeature = 3.0, kLargeFeature = 6.0;
// Of (R13) and (R14): points of either view are up to 0.7 from the nearest one of a lattice, half a
// diagonal, so two distances differ by 1.4.
constexpr double kMatchTolerance = 1.5;
// Over it kMatchTolerance changes a direction by up to 17 degrees.
constexpr double kLeastDistance = 5.0;
constexpr double kReach = 2.0;  // Of poses from matches, which err by kMatchTolerance.

// Matches: three determine a motion, the fourth confirms it.
constexpr std::size_t kLeastConsensus = 4;
// Of rough_agreement(): half of the 0.15 that links must overlap, 3.6 deviations above none.
constexpr double kLeastAgreement = 0.08;
constexpr int kQuickCorrespondences = 250;  // Bounds the time.
// Of alternative_poses(); bounds the time. A shape that repeats in a row has more, and a few tell
// it.
constexpr int kAlternatives = 6;

struct RoughPose {
  RigidMotion b_from_a = RigidMotion::Identity();
  double agreement = 0.0;
};

Eigen::Matrix3Xd columns(const Eigen::Matrix3Xd& points, const std::vector<FeatureMatch>& matches,
                         const std::vector<std::size_t>& chosen, Eigen::Index FeatureMatch::*side) {
  Eigen::Matrix3Xd result(3, static_cast<Eigen::Index>(chosen.size()));
  for (std::size_t k = 0; k < chosen.size(); ++k)
    result.col(static_cast<Eigen::Index>(k)) = points.col(matches[chosen[k]].*side);
  return result;
}

// Motions that explain large sets of matches. Each match seeds one set at most, and no seed is in a
// set found before, so that the sets differ.
std::vector<RigidMotion> consistent_motions(const CoarseView& a, const CoarseView& b,
                                            const std::vector<FeatureMatch>& matches, double cell,
                                            int most) {
  ConsistencyOptions consistency;
  consistency.distance_tolerance = kMatchTolerance * cell;
  consistency.least_distance = kLeastDistance * cell;
  const ConsistencyGraph graph(a.points, b.points, matches, consistency);
  std::vector<std::size_t> seeds(matches.size());
  std::iota(seeds.begin(), seeds.end(), std::size_t{0});
  std::stable_sort(seeds.begin(), seeds.end(),
                   [&](std::size_t i, std::size_t j) { return graph.degree(i) > graph.degree(j); });
  std::vector<bool> used(matches.size(), false);
  std::vector<RigidMotion> motions;
  int tried = 0;
  for (const std::size_t seed : seeds) {
    if (used[seed]) continue;
    if (++tried > most) break;
    const auto set = graph.consensus_around(seed);
    if (set.size() < kLeastConsensus) continue;
    const auto fit = fit_robustly(columns(a.points.points, matches, set, &FeatureMatch::a),
                                  columns(b.points.points, matches, set, &FeatureMatch::b),
                                  kMatchTolerance * cell);
    if (fit.inliers.size() < kLeastConsensus) continue;
    for (const std::size_t k : fit.inliers) used[set[k]] = true;
    motions.push_back(fit.target_from_source);
  }
  return motions;
}

// The most promising first, without those that a better one stands for.
std::vector<RoughPose> promising(const ViewSurface& a, const ViewSurface& b,
                                 const std::vector<RigidMotion>& motions, double reach, int most) {
  std::vector<RoughPose> poses;
  for (const auto& motion : motions)
    poses.push_back({motion, rough_agreement(a, b, motion, reach, kRoughProbes)});
  std::stable_sort(poses.begin(), poses.end(), [](const RoughPose& x, const RoughPose& y) {
    return x.agreement > y.agreement;
  });
  std::vector<RoughPose> kept;
  for (const auto& pose : poses) {
    if (pose.agreement < kLeastAgreement || static_cast<int>(kept.size()) == most) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const RoughPose& other) {
      return same_pose(a, pose.b_from_a, other.b_from_a, reach);
    });
    if (!known) kept.push_back(pose);
  }
  return kept;
}

// The most promising of many poses, refined and judged, the best overlap first.
std::vector<PoseHypothesis> verify_motions(const ViewSurface& a, const ViewSurface& b,
                                           const std::vector<RigidMotion>& motions, double reach,
                                           int most, const JudgeOptions& judge) {
  std::vector<PoseHypothesis> hypotheses;
  for (const auto& pose : promising(a, b, motions, reach, most)) {
    const auto refined = refine_hypothesis(a, b, pose.b_from_a, reach, judge);
    const bool known =
        std::any_of(hypotheses.begin(), hypotheses.end(), [&](const PoseHypothesis& other) {
          return same_pose(a, refined.b_from_a, other.b_from_a, reach);
        });
    if (!known) hypotheses.push_back(refined);
  }
  std::stable_sort(hypotheses.begin(), hypotheses.end(),
                   [](const PoseHypothesis& x, const PoseHypothesis& y) {
                     return x.evidence.overlap > y.evidence.overlap;
                   });
  return hypotheses;
}

// The poses that matches lead to.
std::vector<PoseHypothesis> verify_matches(const CoarseView& a, const CoarseView& b,
                                           const std::vector<FeatureMatch>& matches,
                                           const CoarseScale& scale,
                                           const PairSearchOptions& options) {
  return verify_motions(*a.surface, *b.surface,
                        consistent_motions(a, b, matches, scale.cell, options.seeds),
                        refinement_reach(scale), options.candidates, options.judge);
}

}  // namespace

CoarseView prepare_coarse_view(const ViewSurface& surface, const CoarseScale& scale) {
  CoarseView view;
  view.surface = &surface;
  if (surface.samples().empty()) return view;
  view.points = resample(surface, scale.cell);
  view.features = compute_fpfh(view.points, kSmallFeature * scale.cell, kLargeFeature * scale.cell);
  return view;
}

double refinement_reach(const CoarseScale& scale) { return kReach * scale.cell; }

PoseHypothesis refine_hypothesis(const ViewSurface& a, const ViewSurface& b,
                                 const RigidMotion& b_from_a, double search_distance,
                                 const JudgeOptions& judge) {
  IcpOptions icp;
  icp.association = judge.association;
  icp.correspondences = kQuickCorrespondences;
  icp.search_distance = search_distance;
  icp.tolerance = 0.05;
  icp.max_iterations = 12;
  icp.normal_maps = false;
  icp.final_samples = 0;
  const IcpResult fit = align_pair(a, b, b_from_a, icp);
  PoseHypothesis hypothesis{fit.target_from_source, {}};
  if (fit.usable()) hypothesis.evidence = judge_pose(a, b, fit.target_from_source, judge);
  return hypothesis;
}

std::optional<PoseHypothesis> confirm_pose(const ViewSurface& a, const ViewSurface& b,
                                           const RigidMotion& b_from_a, const CoarseScale& scale,
                                           const JudgeOptions& judge) {
  const double reach = refinement_reach(scale);
  const PoseHypothesis pose = refine_hypothesis(a, b, b_from_a, reach, judge);
  return same_pose(a, pose.b_from_a, b_from_a, reach) ? std::optional(pose) : std::nullopt;
}

bool same_pose(const ViewSurface& view, const RigidMotion& x, const RigidMotion& y,
               double tolerance) {
  const Eigen::Vector3d centre = view.centre();
  return (x * centre - y * centre).norm() + rotation_angle(y.inverse() * x) * 0.5 * view.radius() <=
         tolerance;
}

std::vector<PoseHypothesis> search_pair(const CoarseView& a, const CoarseView& b,
                                        const CoarseScale& scale,
                                        const PairSearchOptions& options) {
  return verify_matches(a, b, match_features(a.features, b.features), scale, options);
}

std::vector<RigidMotion> partial_symmetries(const CoarseView& view, const CoarseScale& scale,
                                            const VerificationThresholds& limits,
                                            const PairSearchOptions& options) {
  FeatureMatchOptions elsewhere;
  elsewhere.own_points = &view.points.points;
  elsewhere.least_shift = kLeastDistance * scale.cell;
  const ViewSurface& surface = *view.surface;
  const auto matches = match_features(view.features, view.features, elsewhere);
  std::vector<RigidMotion> motions;
  const auto add = [&](const RigidMotion& motion) {
    const bool known = std::any_of(motions.begin(), motions.end(), [&](const RigidMotion& other) {
      return same_pose(surface, motion, other, refinement_reach(scale));
    });
    if (!known) motions.push_back(motion);
  };
  for (const auto& [motion, evidence] : verify_matches(view, view, matches, scale, options)) {
    if (!plausible(evidence, surface, surface, limits) || misses_coverage(evidence, limits) ||
        misfits_locally(evidence, surface, surface, limits) ||
        same_pose(surface, motion, RigidMotion::Identity(), refinement_reach(scale)))
      continue;
    add(motion);
    add(motion.inverse());
  }
  return motions;
}

std::vector<PoseHypothesis> alternative_poses(const ViewSurface& a, const ViewSurface& b,
                                              const RigidMotion& b_from_a,
                                              const std::vector<RigidMotion>& a_symmetries,
                                              const std::vector<RigidMotion>& b_symmetries,
                                              const CoarseScale& scale, const JudgeOptions& judge) {
  const double reach = refinement_reach(scale);
  const auto is_given = [&](const RigidMotion& motion) {
    return same_pose(a, motion, b_from_a, reach);
  };
  std::vector<RigidMotion> motions;
  for (const RigidMotion& motion : a_symmetries) motions.push_back(b_from_a * motion);
  for (const RigidMotion& motion : b_symmetries) motions.push_back(motion * b_from_a);
  std::erase_if(motions, is_given);
  auto poses = verify_motions(a, b, motions, reach, kAlternatives, judge);
  std::erase_if(poses, [&](const PoseHypothesis& pose) { return is_given(pose.b_from_a); });
  return poses;
}

}  // namespace relief::registration
