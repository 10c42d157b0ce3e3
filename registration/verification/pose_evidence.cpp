#include "registration/verification/pose_evidence.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include "registration/pairwise/degenerate_directions.h"
#include "registration/pairwise/search_schedule.h"
#include "registration/surface/largest_plane.h"
#include "registration/verification/coherent_residual.h"

namespace relief::registration {

namespace {

// Samples of a view; bounds the time. A fraction of 0.02 is told to 0.006.
constexpr std::size_t kProbes = 500;
// Of normals that may belong together: 37 degrees, near the 40 at which correspondences end.
constexpr double kRoughCosine = 0.8;

// Signed distance of each probe from what the target sees there, and its normal's cosine.
struct Sighting {
  double distance = 0.0, cosine = 0.0;
};

// Calls visit(Sighting) for the probes that fall on a surface that the target sees.
template <typename Visit>
void look_from(const ViewSurface& target, const ViewSurface& source,
               const RigidMotion& target_from_source, std::size_t probes, const Visit& visit) {
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(probes));
  std::vector<SurfacePoint> samples(probes);
  for (std::size_t i = 0; i < probes; ++i) {
    samples[i] = source.sample(source.samples()[i]);
    points.col(static_cast<Eigen::Index>(i)) = target_from_source * samples[i].point;
  }
  std::vector<Eigen::Vector2d> closest;
  if (!target.can_project()) closest = target.closest(points);
  for (std::size_t i = 0; i < probes; ++i) {
    const Eigen::Vector3d point = points.col(static_cast<Eigen::Index>(i));
    const auto pixel = closest.empty() ? target.project(point) : std::optional(closest[i]);
    const auto seen = pixel ? target.at(*pixel) : std::nullopt;
    if (!seen) continue;
    // Points in front of a surface are on the side of its normal.
    visit(Sighting{(point - seen->point).dot(seen->normal),
                   (target_from_source.linear() * samples[i].normal).dot(seen->normal)});
  }
}

double directed_agreement(const ViewSurface& source, const ViewSurface& target,
                          const RigidMotion& target_from_source, double reach, int probes) {
  const auto count = std::min(static_cast<std::size_t>(probes), source.samples().size());
  if (count == 0) return 0.0;
  double score = 0.0;
  look_from(target, source, target_from_source, count, [&](const Sighting& s) {
    if (s.distance > reach && target.can_project())
      score -= 2.0;
    else if (std::abs(s.distance) <= reach && s.cosine >= kRoughCosine)
      score += 1.0;
  });
  return score / static_cast<double>(count);
}

// The band of distances in which residuals should agree, (R10): beyond the reach of the sensor's
// noise, whose samples share it over a few pixels [sample spacings]. Smaller takes that for misfit,
// larger misses misfits that change sign within it (see PoseEvidence::local_rms).
constexpr double kNoiseReach = 5.0;
// Over the smaller view's radius. Smaller leaves few pairs; in larger bands misfits cancel, since
// their sum over the views is nearly zero once ICP has settled.
constexpr double kCoherenceRadii = 0.1;
constexpr double kCoherenceReach = 10.0;  // [sample spacings], at least: the band is never empty.
// Over the smaller view's radius: right poses of the coarsest views that are placed have as much.
// With it, limits of 0.2 are 0.2 % of the radius. Right poses of structured light scans of 250
// spacings show up to 0.12 %, wrong ones of simulated views of 70 spacings 0.4 % to 1.2 %.
constexpr double kCoherenceScaleRadii = 0.01;
constexpr double kStrays = 0.005;  // Part of a view that may be anywhere: 2 of kProbes samples,
constexpr double kLost = 0.02;     // and that the other sensor may have lost: 3 deviations.
// Cosine at which a sensor should see a surface, (R15): 53 degrees, where its samples are 1.7 times
// as far apart. Smaller expects what sensors lose at grazing angles, larger ignores more of a view.
constexpr double kFacing = 0.6;

// Of what two views share. A right pose of a room has more than a tenth beside its largest plane,
// and a wrong one less, which meets by chance (docs/results.md).
constexpr double kPlanarFraction = 0.9;
constexpr std::size_t kPlaneProbes = 300;  // Bounds the time. 0.9 is told to 0.02.

// What the line of sight from the target to samples of the source tells, as fractions of them.
struct SightLines {
  double in_front = 0.0;  // Would have hidden what the target saw.
  double missing = 0.0;   // Face the target where it saw nothing.
};

// Standard deviation of the distance of a sample from what the other view sees there [unit]. Errors
// beyond the noise grow as it does, with the distance from the sensor.
double stddev_between(const ViewSurface& source, const SurfacePoint& sample,
                      const ViewSurface& target, const SurfacePoint& seen, double min_stddev) {
  const double noise = joint_noise(source, target);
  const double own = std::hypot(std::max(source.noise(), source.noise_at(sample)),
                                std::max(target.noise(), target.noise_at(seen)));
  return noise > 0.0 ? own * std::max(1.0, min_stddev / noise) : std::max(own, min_stddev);
}

SightLines look_along(const ViewSurface& source, const ViewSurface& target,
                      const RigidMotion& target_from_source, double min_stddev) {
  SightLines lines;
  const std::size_t probes = std::min(kProbes, source.samples().size());
  if (!target.can_project() || probes == 0) return lines;
  const double part = 1.0 / static_cast<double>(probes);
  const double spacing = coarser_spacing(source, target);
  for (std::size_t i = 0; i < probes; ++i) {
    const SurfacePoint sample = source.sample(source.samples()[i]);
    const Eigen::Vector3d point = target_from_source * sample.point;
    const auto pixel = target.project(point);
    if (!pixel) continue;
    if (const auto seen = target.at(*pixel)) {
      const double margin = finest_search_distance(
          spacing, stddev_between(source, sample, target, *seen, min_stddev));
      if ((point - seen->point).dot(seen->normal) > margin) lines.in_front += part;
    } else if (target.blank(*pixel)) {
      const Eigen::Vector3d normal = target_from_source.linear() * sample.normal;
      if (-target.sight(*pixel).normalized().dot(normal) > kFacing) lines.missing += part;
    }
  }
  return lines;
}

void note_sight_lines(const SightLines& lines, double overlap, PoseEvidence& evidence) {
  const auto note = [&](double part, double& largest, double& largest_ratio) {
    if (part <= 0.0) return;
    largest = std::max(largest, part);
    largest_ratio = std::max(largest_ratio, part / (part + overlap));
  };
  note(lines.in_front, evidence.in_front, evidence.free_space_violation);
  note(lines.missing, evidence.missing, evidence.missing_coverage);
}

// What neighbours share beyond the rounding of their ranges [coherence_scale()].
double beyond_rounding(double shared, const ViewSurface& a, const ViewSurface& b) {
  const double rounding = std::hypot(a.rounding(), b.rounding());
  return std::sqrt(std::max(0.0, shared * shared - rounding * rounding)) / coherence_scale(a, b);
}

// Pairs of samples up to a part of the smaller view's radius, but at least `spacings` apart.
DistanceBand band(const ViewSurface& a, const ViewSurface& b, double nearest, double spacings) {
  const double spacing = coarser_spacing(a, b);
  return {nearest * spacing,
          std::max(spacings * spacing, kCoherenceRadii * std::min(a.radius(), b.radius()))};
}

Eigen::Matrix3Xd points_of(const std::vector<OrientedPoint>& oriented) {
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(oriented.size()));
  for (std::size_t i = 0; i < oriented.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = oriented[i].point;
  return points;
}

// What each view saw of the other at a pose.
struct MutualSighting {
  Correspondences in_b, in_a;  // Of samples of a, and of b.
};

// Samples that two views share.
CorrespondenceOptions shared_samples(const ViewSurface& a, const ViewSurface& b, int probes,
                                     const JudgeOptions& options) {
  CorrespondenceOptions search;
  search.count = probes;
  search.tries = 1;
  search.max_distance = finest_search_distance(coarser_spacing(a, b),
                                               std::max(joint_noise(a, b), options.min_stddev));
  search.max_normal_angle_deg = options.max_normal_angle_deg;
  search.association = options.association;
  return search;
}

MutualSighting look_both_ways(const ViewSurface& a, const ViewSurface& b,
                              const RigidMotion& b_from_a, int probes, const JudgeOptions& options,
                              PoseEvidence& evidence) {
  const CorrespondenceOptions search = shared_samples(a, b, probes, options);
  MutualSighting seen{find_correspondences(a, b, b_from_a, search),
                      find_correspondences(b, a, b_from_a.inverse(), search)};
  evidence.overlap = 0.5 * (seen.in_b.overlap() + seen.in_a.overlap());
  note_sight_lines(look_along(a, b, b_from_a, options.min_stddev), seen.in_b.overlap(), evidence);
  note_sight_lines(look_along(b, a, b_from_a.inverse(), options.min_stddev), seen.in_a.overlap(),
                   evidence);
  return seen;
}

double root_mean_square(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return values.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(values.size()));
}

}  // namespace

bool violates_free_space(const PoseEvidence& evidence, const VerificationThresholds& limits) {
  return evidence.free_space_violation > limits.max_free_space_violation &&
         evidence.in_front > kStrays;
}

bool misses_coverage(const PoseEvidence& evidence, const VerificationThresholds& limits) {
  return evidence.missing_coverage > limits.max_missing_coverage && evidence.missing > kLost;
}

bool misfits_locally(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
                     const VerificationThresholds& limits) {
  return beyond_rounding(evidence.local_rms, a, b) > limits.max_coherent_rms;
}

double coherence_scale(const ViewSurface& a, const ViewSurface& b) {
  return std::max(coarser_spacing(a, b), kCoherenceScaleRadii * std::min(a.radius(), b.radius()));
}

double relative_coherent_rms(const PoseEvidence& evidence, const ViewSurface& a,
                             const ViewSurface& b) {
  return beyond_rounding(evidence.coherent_rms, a, b);
}

double relative_rms(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b) {
  return evidence.rms / largest_plausible_rms(coarser_spacing(a, b), joint_noise(a, b));
}

double largest_ratio(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
                     const VerificationThresholds& limits) {
  const double violation = violates_free_space(evidence, limits)
                               ? evidence.free_space_violation / limits.max_free_space_violation
                               : 0.0;
  return std::max({violation, relative_rms(evidence, a, b) / limits.max_rms,
                   evidence.normal_rms / limits.max_normal_rms,
                   relative_coherent_rms(evidence, a, b) / limits.max_coherent_rms});
}

bool plausible(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
               const VerificationThresholds& limits) {
  return evidence.overlap >= limits.min_overlap && largest_ratio(evidence, a, b, limits) <= 1.0;
}

double rough_agreement(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a,
                       double reach, int probes) {
  assert(reach >= 0.0 && probes > 0);  // 0: of views with one sample.
  return 0.5 * (directed_agreement(a, b, b_from_a, reach, probes) +
                directed_agreement(b, a, b_from_a.inverse(), reach, probes));
}

PoseEvidence judge_free_space(const ViewSurface& a, const ViewSurface& b,
                              const RigidMotion& b_from_a, const JudgeOptions& options) {
  PoseEvidence evidence;
  if (!a.samples().empty() && !b.samples().empty())
    look_both_ways(a, b, b_from_a, static_cast<int>(kProbes), options, evidence);
  return evidence;
}

PoseEvidence judge_pose(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a,
                        const JudgeOptions& options) {
  assert(options.probes > 0);
  PoseEvidence evidence;
  if (a.samples().empty() || b.samples().empty()) return evidence;
  const auto [in_b, in_a] = look_both_ways(a, b, b_from_a, options.probes, options, evidence);

  const SharedSurface shared(b_from_a, RigidMotion::Identity(), in_b, in_a);
  std::vector<double> distances;  // Of a in front of b.
  for (const auto& c : in_b.items) distances.push_back(c.distance);
  for (const auto& c : in_a.items) distances.push_back(-c.distance);
  std::vector<double> turns;  // Between the normals.
  for (std::size_t i = 0; i < shared.points.size(); ++i)
    turns.push_back((shared.points[i].normal - shared.normals[i]).norm());
  evidence.rms = root_mean_square(distances);
  evidence.normal_rms = root_mean_square(turns);
  const Eigen::Matrix3Xd points = points_of(shared.points);
  evidence.coherent_rms = coherent_rms(points, distances, band(a, b, kNoiseReach, kCoherenceReach));
  evidence.local_rms = coherent_rms(points, distances, band(a, b, 0.0, 1.0));
  const double threshold = eigenvalue_threshold(std::max(a.normal_noise(), b.normal_noise()));
  evidence.degenerate = analyse_constraints(shared.points).eigenvalues[0] < threshold;
  return evidence;
}

SharedSurface shared_surface(const ViewSurface& a, const ViewSurface& b,
                             const RigidMotion& b_from_a, const JudgeOptions& options) {
  const CorrespondenceOptions search = shared_samples(a, b, options.probes, options);
  return {b_from_a, RigidMotion::Identity(), find_correspondences(a, b, b_from_a, search),
          find_correspondences(b, a, b_from_a.inverse(), search)};
}

bool shares_one_plane(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a,
                      const JudgeOptions& options) {
  const auto shared =
      find_correspondences(a, b, b_from_a, shared_samples(a, b, options.probes, options)).items;
  std::vector<PlaneProbe> probes;
  for (std::size_t i = 0; i < shared.size(); i += 1 + shared.size() / kPlaneProbes) {
    const auto& [point, normal, unused, pixel] = shared[i].target;
    const double stddev =
        stddev_between(a, shared[i].source, b, shared[i].target, options.min_stddev);
    probes.push_back({point, normal, plane_tolerance(stddev, b.spacing())});
  }
  return !probes.empty() && static_cast<double>(largest_plane(probes).probes.size()) >=
                                kPlanarFraction * static_cast<double>(probes.size());
}

}  // namespace relief::registration
