#include "registration/verification/pose_verification.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "registration/pairwise/robust.h"
#include "registration/pairwise/search_schedule.h"
#include "registration/posegraph/view_graph.h"
#include "registration/verification/common_errors.h"
#include "registration/verification/deviating_views.h"
#include "scan/base/parallel.h"

namespace relief::registration {

namespace {

// Pairs of a view whose fit is judged, the largest overlaps first: more confirm nothing new.
// Bounds the time.
constexpr int kJudgedPairsOfAView = 6;
// However bad a sensor is, pairs that deviate by more than so many times the general limits confirm
// nothing: 5 x 0.2 spacings of coherent residual are one, where wrong poses settle.
constexpr double kWidest = 5.0;
// Stray samples, flying pixels and moving parts stand in space seen empty at right poses as well:
// of the samples that can be compared, fewer than these. [fraction] Scenes of `relief_coarse_runs`
// have 5 % of stray samples at most.
constexpr double kStrays = 0.1;
// Stray samples of pairs that share one plane alone, in the same unit: the overlap of such pairs
// says nothing, and at wrong poses there is rarely less than a twentieth (VerificationThresholds).
constexpr double kPlanarStrays = 0.05;
// Of the samples that can be compared: where more of them move, or are at a wrong pose, what fits
// says little.
constexpr double kMostMoved = 0.5;
constexpr double kFewestStrays = 0.01;  // Of all samples of a view: 5 of the 500 looked at.

// Over the typical radius: wrong poses misfit by as little (link_limits.cpp).
constexpr double kWrongRadii = 0.02;
// A deviation measured within a reach that exceeds it sixfold grows by less in a wider one; one
// that fills its reach, as at wrong poses, grows by a factor of 6 / sqrt(3) or more.
constexpr double kSettled = 1.2;

// One pair of views at the poses that are judged.
struct Judged {
  std::size_t a = 0, b = 0;
  PoseEvidence evidence;
  bool fit_known = false;  // Whether all of the evidence was looked at, or sight lines alone.
  bool confirms = false, allows = false, violates_free_space = false;
  bool planar = false;  // It fits wherever its plane is moved in itself.
  // Overlap where it fits as poses are believed that shape finds, but for empty space; the same,
  // negative, where it does not. 0: it is too little, or planar.
  double fitting_in_part = 0.0;
};

std::vector<Judged> pairs_to_judge(const std::vector<ViewSurface>& surfaces,
                                   const std::vector<RigidMotion>& poses,
                                   const std::vector<ViewRole>& roles) {
  std::vector<Judged> pairs;
  for (const auto& [a, b, unused] : find_meeting_pairs(surfaces, poses, 0.0))
    if (roles[a] != ViewRole::kExcluded && roles[b] != ViewRole::kExcluded)
      pairs.push_back({.a = a, .b = b});
  return pairs;
}

// Sight lines of all pairs; the fit of those that overlap most.
void judge(const std::vector<ViewSurface>& surfaces, const std::vector<RigidMotion>& poses,
           const JudgeOptions& judging, std::vector<Judged>& pairs) {
  const auto relative = [&](const Judged& pair) { return poses[pair.b].inverse() * poses[pair.a]; };
  parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      Judged& pair = pairs[k];
      pair.evidence = judge_free_space(surfaces[pair.a], surfaces[pair.b], relative(pair), judging);
      pair.fit_known = false;
    }
  });
  std::vector<ViewPair> overlapping;
  std::vector<std::size_t> place(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (pairs[k].evidence.overlap >= kCountingOverlap)
      overlapping.push_back({pairs[k].a, pairs[k].b, pairs[k].evidence.overlap});
  const auto strongest = largest_overlaps(surfaces.size(), overlapping, kJudgedPairsOfAView);
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0, s = 0; k < pairs.size() && s < strongest.size(); ++k) {
    if (pairs[k].a != strongest[s].a || pairs[k].b != strongest[s].b) continue;
    chosen.push_back(k);
    ++s;
  }
  parallel_for(chosen.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Judged& pair = pairs[chosen[i]];
      pair.evidence = judge_pose(surfaces[pair.a], surfaces[pair.b], relative(pair), judging);
      pair.fit_known = true;
    }
  });
}

void find_planar_pairs(const std::vector<ViewSurface>& surfaces,
                       const std::vector<RigidMotion>& poses, const JudgeOptions& judging,
                       std::vector<Judged>& pairs) {
  parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      Judged& pair = pairs[k];
      pair.planar =
          pair.fit_known && shares_one_plane(surfaces[pair.a], surfaces[pair.b],
                                             poses[pair.b].inverse() * poses[pair.a], judging);
    }
  });
}

double median_radius(const std::vector<ViewSurface>& surfaces) {
  std::vector<double> radii;
  for (const ViewSurface& surface : surfaces)
    if (!surface.samples().empty()) radii.push_back(surface.radius());
  return radii.empty() ? 0.0 : quantile(std::move(radii), 0.5);
}

double common_stddev_of(const std::vector<ViewSurface>& surfaces,
                        const std::vector<Judged>& pairs) {
  std::vector<PairDeviation> deviations;
  for (const Judged& pair : pairs)
    if (pair.fit_known) deviations.push_back({pair.a, pair.b, pair.evidence.rms});
  return common_stddev(surfaces, deviations);
}

// What the better pairs deviate by [unit].
struct CommonErrors {
  double stddev = 0.0;
  bool settled = true;  // Whether a wider reach finds no more.
};

// Partners are looked for within a reach that follows from the errors expected, so the deviation is
// measured again with the reach that it asks for, until it stays. Wrong poses fill any reach: if it
// does not stay, the first one counts. `pairs` are judged with `judging`, and then with what is
// returned.
CommonErrors measure_common_errors(const std::vector<ViewSurface>& surfaces,
                                   const std::vector<RigidMotion>& poses, JudgeOptions& judging,
                                   std::vector<Judged>& pairs) {
  const double first = common_stddev_of(surfaces, pairs);
  if (!(first > 0.0)) return {};
  const double most = kWrongRadii * median_radius(surfaces);
  for (double stddev = first; stddev <= most;) {
    judging.min_stddev = stddev;
    judge(surfaces, poses, judging, pairs);
    const double wider = common_stddev_of(surfaces, pairs);
    if (wider <= kSettled * stddev) return {stddev, true};
    stddev = wider;
  }
  judging.min_stddev = first;
  judge(surfaces, poses, judging, pairs);
  return {first, false};
}

VerificationThresholds at_counting_overlaps(VerificationThresholds limits) {
  limits.min_overlap = kCountingOverlap;
  return limits;
}

// The limits, widened to what the pairs of these views have in common.
VerificationThresholds limits_of_views(const std::vector<ViewSurface>& surfaces,
                                       const std::vector<Judged>& pairs,
                                       VerificationThresholds limits) {
  std::vector<double> rms, normal_rms, coherent_rms, free_space_violation, noise;
  for (const Judged& pair : pairs) {
    if (!pair.fit_known) continue;
    const ViewSurface &a = surfaces[pair.a], &b = surfaces[pair.b];
    free_space_violation.push_back(pair.evidence.free_space_violation);
    if (pair.evidence.free_space_violation > kStrays) continue;
    rms.push_back(relative_rms(pair.evidence, a, b));
    normal_rms.push_back(pair.evidence.normal_rms);
    coherent_rms.push_back(relative_coherent_rms(pair.evidence, a, b));
    noise.push_back(joint_noise(a, b) / coherence_scale(a, b));
  }
  const auto widen = [](double& limit, std::vector<double> values, double widest) {
    limit =
        std::clamp(kUncommon * quantile(std::move(values), 0.5), limit, std::max(limit, widest));
  };
  widen(limits.max_rms, std::move(rms), kWidest * limits.max_rms);
  widen(limits.max_normal_rms, std::move(normal_rms), kWidest * limits.max_normal_rms);
  widen(limits.max_coherent_rms, std::move(coherent_rms),
        std::max(kWidest * limits.max_coherent_rms,
                 kWarpDeviations * quantile(std::move(noise), 0.5)));
  widen(limits.max_free_space_violation, std::move(free_space_violation),
        kWidest * limits.max_free_space_violation);
  return at_counting_overlaps(limits);
}

// The RMS that the common errors of all pairs explain between two views, as relative_rms() has it.
double explained_rms(const ViewSurface& a, const ViewSurface& b, double common_stddev) {
  const double spacing = coarser_spacing(a, b), noise = joint_noise(a, b);
  return largest_plausible_rms(spacing, std::max(noise, common_stddev)) /
         largest_plausible_rms(spacing, noise);
}

void decide(const std::vector<ViewSurface>& surfaces, const VerificationThresholds& general,
            const CommonErrors& common, std::vector<Judged>& pairs) {
  const VerificationThresholds limits =
      common.settled ? limits_of_views(surfaces, pairs, general) : at_counting_overlaps(general);
  const double strays = std::max(kStrays, limits.max_free_space_violation);
  VerificationThresholds allowed = limits;
  allowed.max_coherent_rms = std::numeric_limits<double>::infinity();
  allowed.max_free_space_violation = strays;
  VerificationThresholds in_part = general;
  in_part.max_free_space_violation = kMostMoved;
  for (Judged& pair : pairs) {
    pair.violates_free_space =
        pair.evidence.free_space_violation > (pair.planar ? kPlanarStrays : strays) &&
        pair.evidence.in_front > kFewestStrays;
    const auto within = [&](const VerificationThresholds& bounds) {
      return pair.fit_known && plausible(pair.evidence, surfaces[pair.a], surfaces[pair.b], bounds);
    };
    const bool leaves_space_free =
        !pair.planar || pair.evidence.free_space_violation <= general.max_free_space_violation;
    pair.confirms = within(limits) && leaves_space_free;
    if (pair.fit_known && !pair.planar && pair.evidence.overlap >= general.min_overlap)
      pair.fitting_in_part = within(in_part) ? pair.evidence.overlap : -pair.evidence.overlap;
    VerificationThresholds of_pair = allowed;
    if (common.settled)
      of_pair.max_rms = std::max(allowed.max_rms,
                                 explained_rms(surfaces[pair.a], surfaces[pair.b], common.stddev));
    pair.allows = pair.confirms || (!pair.planar && within(of_pair));
  }
}

// What the remaining views say of each other.
std::vector<ViewVerification> tally(std::size_t views, const std::vector<Judged>& pairs,
                                    const std::vector<bool>& refuted) {
  std::vector<ViewVerification> result(views);
  std::vector<double> fitting(views, 0.0);
  for (const Judged& pair : pairs) {
    if (refuted[pair.a] && refuted[pair.b]) continue;
    // A refuted view is judged by the others, and says nothing of them.
    for (const auto& [view, other] : {std::pair{pair.a, pair.b}, std::pair{pair.b, pair.a}}) {
      if (refuted[other]) continue;
      if (pair.evidence.overlap >= kCountingOverlap) result[view].overlaps = true;
      if (pair.confirms && !pair.planar)
        result[view].support += pair.evidence.overlap;
      else if (pair.allows)
        result[view].weak_support += pair.evidence.overlap;
      if (pair.fitting_in_part > 0.0) result[view].fits_in_part_with.push_back(other);
      fitting[view] += pair.fitting_in_part;
      if (pair.violates_free_space) result[view].violation += pair.evidence.in_front;
    }
  }
  for (std::size_t i = 0; i < views; ++i)
    if (fitting[i] <= 0.0) result[i].fits_in_part_with.clear();
  return result;
}

// The view with most against it; `views` where no view has more against than for it.
std::size_t most_contradicted(const std::vector<ViewVerification>& tallied,
                              const std::vector<ViewRole>& roles,
                              const std::vector<bool>& refuted) {
  std::size_t worst = tallied.size();
  double excess = 0.0;
  for (std::size_t i = 0; i < tallied.size(); ++i) {
    if (refuted[i] || roles[i] != ViewRole::kFree) continue;
    const double against = tallied[i].violation - tallied[i].support - tallied[i].weak_support;
    // Of two views with the same against them the first one stays.
    if (tallied[i].violation > 0.0 && against > 0.0 && against >= excess) {
      worst = i;
      excess = against;
    }
  }
  return worst;
}

// Of pairs of views that are not refuted. Small patches fit better, also at wrong poses: they do
// not count.
std::vector<RelativeDeviation> deviations_of(const std::vector<ViewSurface>& surfaces,
                                             const std::vector<Judged>& pairs,
                                             const std::vector<bool>& refuted, double min_overlap) {
  std::vector<RelativeDeviation> deviations;
  for (const Judged& pair : pairs)
    if (pair.fit_known && !refuted[pair.a] && !refuted[pair.b] &&
        pair.evidence.overlap >= min_overlap)
      deviations.push_back(
          {pair.a, pair.b, relative_rms(pair.evidence, surfaces[pair.a], surfaces[pair.b])});
  return deviations;
}

}  // namespace

PoseVerification verify_poses(const std::vector<ViewSurface>& surfaces,
                              const std::vector<RigidMotion>& world_from_view,
                              const std::vector<ViewRole>& roles,
                              const PoseVerificationOptions& options) {
  assert(surfaces.size() == world_from_view.size() && surfaces.size() == roles.size());
  auto pairs = pairs_to_judge(surfaces, world_from_view, roles);
  JudgeOptions judging;
  judging.association = options.association;
  judge(surfaces, world_from_view, judging, pairs);
  const CommonErrors common = measure_common_errors(surfaces, world_from_view, judging, pairs);
  find_planar_pairs(surfaces, world_from_view, judging, pairs);
  decide(surfaces, options.limits, common, pairs);

  const std::size_t views = surfaces.size();
  std::vector<bool> refuted(views, false);
  PoseVerification result;
  for (;;) {
    result.views = tally(views, pairs, refuted);
    const std::size_t worst = most_contradicted(result.views, roles, refuted);
    if (worst == views) break;
    refuted[worst] = true;
  }
  std::vector<ViewPair> confirmed;
  for (const Judged& pair : pairs)
    if (pair.confirms && !refuted[pair.a] && !refuted[pair.b])
      confirmed.push_back({pair.a, pair.b, pair.evidence.overlap});
  result.group = connected_groups(views, confirmed);
  const DeviatingViews deviating = find_deviating_views(
      views, deviations_of(surfaces, pairs, refuted, options.limits.min_overlap));
  for (std::size_t i = 0; i < views; ++i) {
    result.views[i].refuted = refuted[i];
    result.views[i].deviates_alone = deviating.alone[i];
    result.views[i].deviates_with_group = deviating.with_group[i];
  }
  return result;
}

}  // namespace relief::registration
