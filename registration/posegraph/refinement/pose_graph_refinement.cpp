#include "registration/posegraph/refinement/pose_graph_refinement.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "registration/pairwise/robust.h"
#include "registration/posegraph/pose_step.h"
#include "registration/posegraph/refinement/pair_information.h"
#include "registration/posegraph/refinement/pose_graph_system.h"
#include "scan/base/memory/paged_lists.h"
#include "scan/base/parallel.h"
#include "scan/base/parallel_batches.h"

namespace relief::registration {

namespace {

// Directed pairs whose patches are summed, and made larger where there are many, at a time.
constexpr std::size_t kPairsAtOnce = 64;
// Views whose samples are chosen at a time. Bounds the memory; changes no result.
constexpr std::size_t kViewsAtOnce = 64;

// Pairs of views, of which all patches are kept for loop closures. Beyond, patches are four times
// as wide, and a sixteenth of the memory: 16 kB a pair, with 5000 patches a view.
constexpr std::size_t kPairsWithFinePatches = 500;

// Two halves of so many steps are taken at a time. Others follow where both halves moved so many
// times as far as the earlier one alone. Steps at one pace give 2, steps that halve what is left 1
// + 1/8, and steps to and fro 1.
constexpr int kHalfOfSteps = 3;
constexpr double kLeastProgress = 1.25;

double median_spacing(const std::vector<const ViewSurface*>& surfaces) {
  std::vector<double> spacings;
  for (const ViewSurface* surface : surfaces)
    if (!surface->samples().empty()) spacings.push_back(surface->spacing());
  return quantile(spacings, 0.5);
}

// The pairs of views while their poses move by small steps about one centre.
class MovingPairs {
 public:
  MovingPairs(const std::vector<const ViewSurface*>& surfaces, const std::vector<ViewPair>& pairs,
              const PoseGraphRefinementOptions& options, std::vector<RigidMotion> world_from_view)
      : surfaces_(surfaces),
        pairs_(pairs),
        options_(options),
        start_(world_from_view),
        poses_(std::move(world_from_view)),
        since_(start_.size(), RigidTangent::Zero()) {
    compression_.search = options.search;
    compression_.centre = common_centre(surfaces, start_);
    for (std::size_t i = 0; i < options.kept_motions.size(); ++i)
      projection_.push_back(without_motions_of(i));
    measure_deviations();
  }

  const std::vector<RigidMotion>& poses() const { return poses_; }
  const Eigen::Vector3d& centre() const { return compression_.centre; }

  /// The equations that `pairs`, compressed at some poses, give.
  PoseGraphSystem system(const std::vector<PairInformation>& pairs,
                         const std::vector<bool>& held) const {
    return PoseGraphSystem(surfaces_, pairs, held, compression_.centre, projection_);
  }

  /// What residuals of each directed pair deviate by at the present poses, until measured anew.
  void measure_deviations() {
    sigmas_ = parallel_map<double>(2 * pairs_.size(), [&](std::size_t i) {
      const std::size_t source = source_of(pairs_, i), target = target_of(pairs_, i);
      return pair_deviation(*surfaces_[source], *surfaces_[target],
                            poses_[target].inverse() * poses_[source], options_.search);
    });
  }

  /// The pairs at the present poses, in both directions.
  std::vector<PairInformation> compress(std::size_t samples) const {
    return compress_all(samples, 0.0, [](PairInformation&) {});
  }

  /// The same, with the scores of patches of edge `patch` [unit], which are added up too. Of many
  /// pairs larger patches are kept.
  std::vector<PairInformation> compress(std::size_t samples, double patch,
                                        ClusterScores& scores) const {
    return compress_all(samples, patch, [&](PairInformation& pair) {
      scores.add(pair);
      if (!keeps_fine_patches()) pair.patches = ClusterScores::larger(pair.patches);
    });
  }
  bool keeps_fine_patches() const { return pairs_.size() <= kPairsWithFinePatches; }

  /// Moves views by tangents about the centre; those with a zero one stay to the bit. The largest
  /// motion of a sample [unit].
  double move(const std::vector<RigidTangent>& tangents) {
    const auto before = poses_;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (tangents[i].isZero(0.0)) continue;
      poses_[i] = moved(before[i], tangents[i], compression_.centre);
      since_[i] += tangents[i];
    }
    return largest_motion_since(before);
  }
  /// Of a sample [unit].
  double largest_motion_since(const std::vector<RigidMotion>& before) const {
    return largest_motion(surfaces_, before, poses_);
  }

 private:
  // Along which the view's centre and its rim move in world axes: a part of their displacement.
  Matrix6d without_motions_of(std::size_t i) const {
    const Eigen::Vector3d centre = start_[i] * surfaces_[i]->centre();
    const Matrix6d about_view = tangents_about(centre - compression_.centre),
                   about_common = tangents_about(compression_.centre - centre);
    const double radius = surfaces_[i]->radius();
    return about_common * without_motions(options_.kept_motions[i], centre, radius * radius) *
           about_view;
  }

  PagedLists<std::uint32_t> samples_of_views(std::size_t samples) const {
    PagedLists<std::uint32_t> of_views;
    parallel_map_in_batches<std::vector<std::uint32_t>>(
        surfaces_.size(), kViewsAtOnce,
        [&](std::size_t i) { return in_grid_order(*surfaces_[i], samples); },
        [&](std::size_t, const std::vector<std::uint32_t>& of_view) { of_views.add(of_view); });
    return of_views;
  }

  // Calls visit(pair) in the order of the pairs.
  template <typename Visit>
  std::vector<PairInformation> compress_all(std::size_t samples, double patch,
                                            const Visit& visit) const {
    const PagedLists<std::uint32_t> of_view = samples_of_views(samples);
    std::vector<PairInformation> all(2 * pairs_.size());
    parallel_map_in_batches<PairInformation>(
        all.size(), kPairsAtOnce,
        [&](std::size_t i) { return compress_pair(i, of_view[source_of(pairs_, i)], patch); },
        [&](std::size_t i, PairInformation&& pair) {
          all[i] = std::move(pair);
          visit(all[i]);
        });
    return all;
  }

  PairInformation compress_pair(std::size_t i, std::span<const std::uint32_t> samples,
                                double patch) const {
    const std::size_t source = source_of(pairs_, i), target = target_of(pairs_, i);
    PairInformation sum;
    if (sigmas_[i] > 0.0) {
      PairInformationOptions compression = compression_;
      compression.sigma = sigmas_[i];
      compression.patch = patch;
      sum = pair_information(*surfaces_[source], *surfaces_[target], poses_[source], poses_[target],
                             samples, compression);
    }
    sum.source = source;
    sum.target = target;
    if (sigmas_[i] <= 0.0) return sum;
    if (!options_.normals.empty())
      add_normals(options_.normals[i], start_[target], compression_.centre,
                  since_[source] - since_[target], sum);
    ignore_motions(options_.degenerate_directions, compression_.centre, sum);
    return sum;
  }

  const std::vector<const ViewSurface*>& surfaces_;
  const std::vector<ViewPair>& pairs_;
  const PoseGraphRefinementOptions& options_;
  PairInformationOptions compression_;
  std::vector<double> sigmas_;        // Of directed pairs [unit].
  std::vector<Matrix6d> projection_;  // See AllowedMotions.
  std::vector<RigidMotion> start_, poses_;
  std::vector<RigidTangent> since_;  // What the views moved by, all in all.
};

// What a step of one standard deviation changes, relative to what Gauss-Newton expects.
double step_gain_at(const MovingPairs& views, const std::vector<bool>& held, std::size_t samples) {
  const auto here = views.compress(samples);
  const PoseGraphSystem system = views.system(here, held);
  const auto random_perturbation = system.random_perturbation();
  MovingPairs beside = views;
  beside.move(random_perturbation);
  return system.step_gain(beside.compress(samples), random_perturbation);
}

// Renewed correspondences follow the motion, so the score changes by less than the information
// matrix predicts, and a plain Gauss-Newton step falls short.
PoseGraphStep newton_step(const PoseGraphSystem& system, double step_gain) {
  PoseGraphStep step = system.step();
  for (auto& tangent : step.tangents) tangent /= step_gain;
  return step;
}

// Takes a step. The largest motion of a sample [unit]; nothing for one that cannot be taken.
std::optional<double> take(const PoseGraphStep& step, MovingPairs& views,
                           PoseGraphRefinement& result) {
  result.solves.push_back(step.summary);
  if (!step.usable()) return std::nullopt;
  ++result.iterations;
  return views.move(step.tangents);
}

// The steps before the last one. The gain of one step scales the next one (Barzilai and Borwein
// 1988).
class NewtonIterations {
 public:
  NewtonIterations(const std::vector<bool>& held, const PoseGraphRefinementOptions& options,
                   MovingPairs& views, PoseGraphRefinement& result)
      : held_(held), options_(options), views_(views), result_(result) {}

  // Steps until the poses stand still, or go to and fro. Whether all could be taken.
  bool run() {
    bool progresses = true;
    while (usable_ && progresses && !done()) {
      const auto start = views_.poses();
      take_half();
      const double half = views_.largest_motion_since(start);
      take_half();
      progresses = views_.largest_motion_since(start) > kLeastProgress * half;
    }
    return usable_;
  }

 private:
  bool done() const {
    return result_.iterations >= options_.max_iterations ||
           (result_.iterations > 0 && result_.last_motion <= options_.tolerance);
  }

  void take_half() {
    for (int i = 0; i < kHalfOfSteps && usable_ && !done(); ++i) take_one();
  }

  void take_one() {
    auto pairs = views_.compress(options_.step_samples);
    const double step_gain =
        before_.empty() ? 1.0 : views_.system(before_, held_).step_gain(pairs, step_.tangents);
    step_ = newton_step(views_.system(pairs, held_), step_gain);
    before_ = std::move(pairs);
    const auto motion = take(step_, views_, result_);
    usable_ = motion.has_value();
    if (usable_) result_.last_motion = *motion;
  }

  const std::vector<bool>& held_;
  const PoseGraphRefinementOptions& options_;
  MovingPairs& views_;
  PoseGraphRefinement& result_;
  std::vector<PairInformation> before_;
  PoseGraphStep step_;
  bool usable_ = true;
};

}  // namespace

PoseGraphRefinement refine_pose_graph(const std::vector<const ViewSurface*>& surfaces,
                                      const std::vector<ViewPair>& pairs,
                                      const std::vector<bool>& held,
                                      const PoseGraphRefinementOptions& options,
                                      std::vector<RigidMotion>& world_from_view) {
  PoseGraphRefinement result;
  MovingPairs views(surfaces, pairs, options, world_from_view);
  if (!NewtonIterations(held, options, views, result).run()) return result;
  views.measure_deviations();
  const double step_gain = step_gain_at(views, held, options.step_samples);
  ClusterScores scores(surfaces.size());
  auto all = views.compress(options.last_samples, options.patch * median_spacing(surfaces), scores);
  const PoseGraphSystem system = views.system(all, held);
  const double inflation = system.variance_inflation(scores);
  auto covariance = system.covariance(views.poses(), scores, inflation, step_gain);
  const PoseGraphStep step = newton_step(system, step_gain);
  if (!covariance || !take(step, views, result)) return result;
  result.covariance = std::move(*covariance);
  result.last = {std::move(all), step.tangents, views.centre(), step_gain,
                 views.keeps_fine_patches() ? inflation : 1.0};
  world_from_view = views.poses();
  result.solved = true;
  return result;
}

std::vector<const ViewSurface*> pointers_to(const std::vector<ViewSurface>& surfaces) {
  std::vector<const ViewSurface*> pointers;
  for (const ViewSurface& surface : surfaces) pointers.push_back(&surface);
  return pointers;
}

double largest_motion(const std::vector<const ViewSurface*>& surfaces,
                      const std::vector<RigidMotion>& before,
                      const std::vector<RigidMotion>& after) {
  double largest = 0.0;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Eigen::Vector3d centre = surfaces[i]->centre();
    const double turn = rotation_angle(after[i] * before[i].inverse());
    largest = std::max(
        largest, (after[i] * centre - before[i] * centre).norm() + turn * surfaces[i]->radius());
  }
  return largest;
}

}  // namespace relief::registration
