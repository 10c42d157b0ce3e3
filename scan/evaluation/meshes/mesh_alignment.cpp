#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "relief/evaluation/mesh_errors.h"
#include "scan/base/counter_random.h"
#include "scan/base/linear_algebra.h"
#include "scan/base/median.h"
#include "scan/base/parallel.h"
#include "scan/base/robust_scales.h"
#include "scan/evaluation/meshes/surface_samples.h"
#include "scan/mesh/triangle_tree.h"

namespace relief::evaluation {

namespace {

using Points = std::vector<Eigen::Vector3d>;

constexpr std::size_t kGrain = 512;  // Points of one piece of work; changes no result.
// Many short fits of few points, and longer ones from the best of them. Of 96 random rotations one
// is within 30 degrees of any in half of all cases, and within 49 degrees in 95 %.
constexpr int kStarts = 96, kStartsKept = 4;
// Bounds of the time: 96 x 300 x 12 closest points for all short fits. More rank the starts better.
constexpr std::size_t kFewSamples = 300;
constexpr int kFewRounds = 12, kMostRounds = 100;

Points surface_points(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed) {
  Points points;
  for (const SurfaceSample& sample : sample_surface(mesh, count, seed))
    points.push_back(point_at(mesh, sample));
  return points;
}

Eigen::Vector3d mean_of(const Points& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

// The true surface, its place and its size.
struct Target {
  TriangleTree tree;
  Eigen::Vector3d centre;
  double size = 0.0;

  explicit Target(const TriangleMesh& mesh, const Points& points)
      : tree(mesh), centre(mean_of(points)) {
    for (const auto& point : points) size = std::max(size, (point - centre).norm());
  }
};

// One point's foot on the truth.
struct Foot {
  Eigen::Vector3d from, offset, normal;
  double distance = 0.0;
};

std::vector<Foot> feet_of(const Target& target, const Points& points, const RigidMotion& motion) {
  std::vector<Foot> feet(points.size());
  parallel_for(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Vector3d from = motion * points[i];
      const auto closest = *target.tree.closest(from);
      feet[i] = {from, closest.on_face.point - from,
                 face_cross(target.tree.mesh(), closest.face).stableNormalized(), closest.distance};
    }
  });
  return feet;
}

double median_distance(const std::vector<Foot>& feet) {
  std::vector<double> distances;
  for (const Foot& foot : feet) distances.push_back(foot.distance);
  return median(distances);
}

// Tukey's biweight for the standard deviation that the median stands for.
double tukey_weight(double distance, double median_distance) {
  const double limit = kTukeyScale * kSigmaPerMedian * median_distance;
  if (distance > limit) return 0.0;
  const double share = limit > 0.0 ? distance / limit : 0.0;
  return (1.0 - share * share) * (1.0 - share * share);
}

// The motion about the target's centre that least squares wants next. Translations are in units of
// the target's size, so that the damping treats rotation alike.
RigidMotion next_step(const std::vector<Foot>& feet, const Target& target) {
  const double scale = median_distance(feet);
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  RigidTangent right = RigidTangent::Zero();
  for (const Foot& foot : feet) {
    const double weight = tukey_weight(foot.distance, scale);
    RigidTangent row;
    row << (foot.from - target.centre).cross(foot.normal), target.size * foot.normal;
    normal += weight * row * row.transpose();
    right += weight * row * foot.normal.dot(foot.offset);
  }
  // Directions in which the surface slides along itself have no say in the motion.
  normal.diagonal().array() += 1e-9 * normal.trace();
  RigidTangent step = solve_symmetric(normal, right);
  step.tail<3>() *= target.size;
  const RigidMotion about_centre = motion_from_tangent(step);
  return Eigen::Translation3d(target.centre) * about_centre * Eigen::Translation3d(-target.centre);
}

// How far a motion moves points of the target at most.
double largest_move(const RigidMotion& step, const Target& target) {
  return rotation_angle(step) * target.size + (step * target.centre - target.centre).norm();
}

MeshAlignment fit(const Target& target, const Points& points, const RigidMotion& start,
                  int rounds) {
  MeshAlignment best;
  best.median_distance = std::numeric_limits<double>::infinity();
  RigidMotion motion = start;
  for (int round = 0; round < rounds; ++round) {
    const auto feet = feet_of(target, points, motion);
    const RigidMotion step = next_step(feet, target);
    motion = step * motion;
    best.iterations = round + 1;
    // Far below what the distances can tell; for a copy, whose distances vanish, below rounding.
    best.converged =
        largest_move(step, target) < std::max(1e-3 * median_distance(feet), 1e-10 * target.size);
    if (best.converged) break;
  }
  best.truth_from_result = motion;
  best.median_distance = median_distance(feet_of(target, points, motion));
  return best;
}

// Rotations all over: uniformly random unit quaternions (Shoemake 1992), the identity first.
std::vector<RigidMotion> starts_about(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                      const CounterRandom& random) {
  std::vector<RigidMotion> starts;
  for (std::uint64_t i = 0; i < kStarts; ++i) {
    const double share = random.uniform(3 * i);
    const double a = 2.0 * std::numbers::pi * random.uniform(3 * i + 1);
    const double b = 2.0 * std::numbers::pi * random.uniform(3 * i + 2);
    const double near = std::sqrt(1.0 - share), far = std::sqrt(share);
    const Eigen::Quaterniond rotation =
        i == 0 ? Eigen::Quaterniond::Identity()
               : Eigen::Quaterniond(far * std::cos(b), near * std::sin(a), near * std::cos(a),
                                    far * std::sin(b));
    starts.push_back(
        RigidMotion(Eigen::Translation3d(to) * rotation * Eigen::Translation3d(-from)));
  }
  return starts;
}

// The best of short fits with few points from everywhere.
std::vector<RigidMotion> good_starts(const Target& target, const Points& points,
                                     std::uint64_t seed) {
  const auto starts = starts_about(mean_of(points), target.centre, CounterRandom(seed, 1));
  std::vector<MeshAlignment> fits(starts.size());
  parallel_for(fits.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) fits[i] = fit(target, points, starts[i], kFewRounds);
  });
  std::stable_sort(fits.begin(), fits.end(), [](const auto& a, const auto& b) {
    return a.median_distance < b.median_distance;
  });
  std::vector<RigidMotion> good;
  for (int i = 0; i < kStartsKept; ++i) good.push_back(fits[i].truth_from_result);
  return good;
}

Result<MeshAlignment> align(const TriangleMesh& result, const TriangleMesh& truth,
                            const MeshAlignmentOptions& options, const Context& context) {
  const Points true_points = surface_points(truth, options.samples, context.seed);
  const Points points = surface_points(result, options.samples, context.seed);
  if (true_points.empty() || points.empty())
    return Error{ErrorKind::kBadInput, "a mesh without area cannot be aligned"};
  const Target target(truth, true_points);
  std::vector<RigidMotion> starts = {RigidMotion::Identity()};
  if (options.any_start) {
    const Points few = surface_points(result, kFewSamples, context.seed);
    for (const RigidMotion& start : good_starts(target, few, context.seed)) starts.push_back(start);
  }
  MeshAlignment best;
  best.median_distance = std::numeric_limits<double>::infinity();
  const Points some = surface_points(result, options.samples / 10, context.seed);
  for (const RigidMotion& start : starts) {
    const MeshAlignment found = fit(target, some, start, kMostRounds / 2);
    if (found.median_distance < best.median_distance) best = found;
  }
  return fit(target, points, best.truth_from_result, kMostRounds);
}

}  // namespace

Result<MeshAlignment> align_mesh(const TriangleMesh& result, const TriangleMesh& truth,
                                 const MeshAlignmentOptions& options, const Context& context) {
  return run_in(context, [&] { return align(result, truth, options, context); });
}

}  // namespace relief::evaluation
