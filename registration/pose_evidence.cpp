#include "registration/pose_evidence.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <vector>

#include "registration/search_schedule.h"
#include "registration/slippage.h"

namespace relief {

namespace {

constexpr std::size_t kProbes = 500;
constexpr double kRoughCosine = 0.8;  // Of normals that may belong together.

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

constexpr double kCoherenceRadii = 0.1;  // Side of the cells of samples that should agree.
constexpr double kStrays = 0.005;        // Part of a view's samples that may be anywhere.

void note_contradiction(double in_front, double overlap, PoseEvidence& evidence) {
  if (in_front <= 0.0) return;
  evidence.in_front = std::max(evidence.in_front, in_front);
  evidence.contradiction = std::max(evidence.contradiction, in_front / (in_front + overlap));
}

double root_mean_square(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return values.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(values.size()));
}

// From the products of the distances of different samples in one cell, in which independent noise
// averages out (C3): (sum of r)^2 - sum of r^2 over the ordered pairs of each cell.
double coherent_rms(const std::vector<OrientedPoint>& points, const std::vector<double>& distances,
                    double cell) {
  if (points.empty()) return 0.0;
  struct Sums {
    double count = 0.0, sum = 0.0, squares = 0.0;
  };
  std::map<std::array<long, 3>, Sums> cells;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d index = ((points[i].point - points[0].point) / cell).array().floor();
    Sums& sums = cells[{static_cast<long>(index.x()), static_cast<long>(index.y()),
                        static_cast<long>(index.z())}];
    ++sums.count;
    sums.sum += distances[i];
    sums.squares += distances[i] * distances[i];
  }
  double products = 0.0, pairs = 0.0;
  for (const auto& [unused, sums] : cells) {
    products += sums.sum * sums.sum - sums.squares;
    pairs += sums.count * (sums.count - 1.0);
  }
  return pairs > 0.0 ? std::sqrt(std::max(0.0, products / pairs)) : 0.0;
}

}  // namespace

bool contradicts(const PoseEvidence& evidence, const PlausibleEvidence& limits) {
  return evidence.contradiction > limits.max_contradiction && evidence.in_front > kStrays;
}

bool plausible(const PoseEvidence& evidence, const ViewSurface& a, const ViewSurface& b,
               const PlausibleEvidence& limits) {
  const double rms =
      largest_plausible_rms(std::max(a.spacing(), b.spacing()), std::hypot(a.noise(), b.noise()));
  return evidence.overlap >= limits.min_overlap && evidence.rms <= limits.max_rms * rms &&
         evidence.coherent_rms <= limits.max_coherent_rms * std::max(a.spacing(), b.spacing()) &&
         !contradicts(evidence, limits);
}

double contradiction(const ViewSurface& source, const ViewSurface& target,
                     const RigidMotion& target_from_source, double margin) {
  const std::size_t probes = std::min(kProbes, source.samples().size());
  if (!target.can_project() || probes == 0) return 0.0;
  std::size_t in_front = 0;
  look_from(target, source, target_from_source, probes,
            [&](const Sighting& s) { in_front += s.distance > margin ? 1 : 0; });
  return static_cast<double>(in_front) / static_cast<double>(probes);
}

double rough_agreement(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a,
                       double reach, int probes) {
  assert(reach > 0.0 && probes > 0);
  return 0.5 * (directed_agreement(a, b, b_from_a, reach, probes) +
                directed_agreement(b, a, b_from_a.inverse(), reach, probes));
}

PoseEvidence judge_pose(const ViewSurface& a, const ViewSurface& b, const RigidMotion& b_from_a,
                        const JudgeOptions& options) {
  assert(options.probes > 0);
  PoseEvidence evidence;
  if (a.samples().empty() || b.samples().empty()) return evidence;
  const double margin =
      finest_search_distance(std::max(a.spacing(), b.spacing()), std::hypot(a.noise(), b.noise()));
  CorrespondenceOptions search;
  search.count = options.probes;
  search.tries = 1;
  search.max_distance = margin;
  search.max_normal_angle_deg = options.max_normal_angle_deg;
  search.association = options.association;
  const auto in_b = find_correspondences(a, b, b_from_a, search);
  const auto in_a = find_correspondences(b, a, b_from_a.inverse(), search);
  evidence.overlap = 0.5 * (in_b.overlap() + in_a.overlap());
  note_contradiction(contradiction(a, b, b_from_a, margin), in_b.overlap(), evidence);
  note_contradiction(contradiction(b, a, b_from_a.inverse(), margin), in_a.overlap(), evidence);

  std::vector<OrientedPoint> shared;
  std::vector<double> distances;  // Of a in front of b.
  for (const auto& c : in_b.items) {
    shared.push_back({c.target.point, c.target.normal});
    distances.push_back(c.distance);
  }
  for (const auto& c : in_a.items) {
    shared.push_back({b_from_a * c.target.point, b_from_a.linear() * c.target.normal});
    distances.push_back(-c.distance);
  }
  const double cell = kCoherenceRadii * std::min(a.radius(), b.radius());
  evidence.rms = root_mean_square(distances);
  evidence.coherent_rms = coherent_rms(shared, distances, cell);
  const double threshold = stiffness_threshold(std::max(a.normal_noise(), b.normal_noise()));
  evidence.slides = analyse_stability(shared).stiffness[0] < threshold;
  return evidence;
}

}  // namespace relief
