#include "registration/posegraph/refinement/pose_graph_refinement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "registration/pairwise/robust.h"
#include "registration/posegraph/joint/joint_refinement.h"
#include "registration/posegraph/refinement/pair_information.h"
#include "registration/posegraph/refinement/pose_graph_system.h"
#include "relief/scan/context.h"
#include "scan/base/linear_algebra.h"
#include "scan/base/robust_scales.h"
#include "tests/registration/bumpy_object.h"
#include "tests/registration/relief_views.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::registration {
namespace {

using testing::mean_displacements;
using testing::perturbed;
using testing::poses_of;

struct Ring {
  explicit Ring(std::uint32_t seed, double noise = 0.3) {
    truth = testing::ring_of_views({.noise = noise, .seed = seed});
    for (const auto& view : truth) surfaces.emplace_back(view);
  }
  double spacing() const { return surfaces[0].spacing(); }
  std::vector<RangeView> truth;
  std::vector<ViewSurface> surfaces;
};

PoseGraphRefinementOptions options_for(const Ring& ring) {
  PoseGraphRefinementOptions options;
  options.search.max_distance = 5.0 * ring.spacing();
  options.tolerance = 1e-3 * ring.spacing();
  return options;
}

std::vector<ViewPair> pairs_of(const Ring& ring) {
  ViewGraphOptions graph;
  graph.max_distance = 5.0 * ring.spacing();
  return find_overlapping_pairs(ring.surfaces, poses_of(ring.truth), graph);
}

std::vector<bool> first_held(std::size_t views) {
  std::vector<bool> held(views, false);
  held[0] = true;
  return held;
}

TEST(PairInformation, TakesInnerAndEdgeSamplesInProportion) {
  const Ring ring(1);
  const ViewSurface& view = ring.surfaces[0];
  const auto inner = view.samples(), edge = view.edge_samples();
  ASSERT_FALSE(edge.empty());
  EXPECT_EQ(in_grid_order(view, 0).size(), inner.size() + edge.size());
  const auto some = in_grid_order(view, 3000);
  EXPECT_EQ(some.size(), 3000u);
  EXPECT_TRUE(std::is_sorted(some.begin(), some.end()));
  const auto from_edge = std::count_if(some.begin(), some.end(), [&](std::uint32_t i) {
    return std::find(edge.begin(), edge.end(), i) != edge.end();
  });
  const double part =
      static_cast<double>(edge.size()) / static_cast<double>(inner.size() + edge.size());
  EXPECT_NEAR(static_cast<double>(from_edge), 3000.0 * part, 1.0);
}

PairInformationOptions information_options(const Ring& ring) {
  PairInformationOptions options;
  options.search.max_distance = 5.0 * ring.spacing();
  options.patch = 8.0 * ring.spacing();
  options.centre = Eigen::Vector3d(3.0, -2.0, 1.0);
  return options;
}

TEST(PairInformation, IsTheSumOverItsResiduals) {
  const Ring ring(1);
  const auto poses = poses_of(ring.truth);
  const PairInformationOptions options = information_options(ring);
  const auto compressed = pair_information(ring.surfaces[0], ring.surfaces[1], poses[0], poses[1],
                                           in_grid_order(ring.surfaces[0], 3000), options);

  const RigidMotion target_from_source = poses[1].inverse() * poses[0];
  const double sigma =
      find_correspondences(ring.surfaces[0], ring.surfaces[1], target_from_source, options.search)
          .sigma;
  std::vector<Correspondence> all;
  CorrespondenceOptions whole = options.search;
  whole.part = SurfacePart::kWhole;
  append_correspondences(ring.surfaces[0], ring.surfaces[1], target_from_source,
                         in_grid_order(ring.surfaces[0], 3000), whole, all);
  Matrix6d information = Matrix6d::Zero();
  RigidTangent score = RigidTangent::Zero();
  for (const auto& c : all) {
    if (std::abs(c.distance) > 4.0 * sigma) continue;
    const Eigen::Vector3d p = poses[1] * c.target.point - options.centre;
    const Eigen::Vector3d n = poses[1].linear() * c.target.normal;
    RigidTangent j;
    j << p.cross(n), n;
    const double r = c.distance / sigma;
    information += cauchy_weight(r, kCauchyScale) / (sigma * sigma) * j * j.transpose();
    score += cauchy_weight(r, kCauchyScale) * r / sigma * j;
  }
  EXPECT_LT((compressed.information - information).norm(), 1e-10 * information.norm());
  EXPECT_LT((compressed.score - score).norm(), 1e-10 * score.norm());
  RigidTangent of_patches = RigidTangent::Zero();
  for (const auto& patch : compressed.patches) of_patches += patch.score;
  EXPECT_GT(compressed.patches.size(), 20u);
  EXPECT_LT((of_patches - score).norm(), 1e-9 * score.norm());
}

TEST(PairInformation, IsIndifferentToMotionsThatAreIgnored) {
  const Ring ring(1);
  const auto poses = poses_of(ring.truth);
  const PairInformationOptions options = information_options(ring);
  const auto all = pair_information(ring.surfaces[0], ring.surfaces[1], poses[0], poses[1],
                                    in_grid_order(ring.surfaces[0], 3000), options);
  DegenerateDirection slide;
  slide.motion << 0.0, 0.0, 0.0, 0.6, 0.8, 0.0;
  DegenerateDirection turn;
  turn.centre = Eigen::Vector3d(20.0, 10.0, -5.0);
  turn.motion << 0.0, 0.6, 0.8, 2.0, 1.0, 0.0;
  auto rest = all;
  ignore_motions({slide, turn}, options.centre, rest);
  // A turn about another point moves the centre, too.
  RigidTangent turn_about_centre = turn.motion;
  turn_about_centre.tail<3>() += turn.motion.head<3>().cross(options.centre - turn.centre);
  const double size = all.information.norm(), score = all.score.norm();
  for (const RigidTangent& motion : {slide.motion, turn_about_centre}) {
    EXPECT_LT((rest.information * motion).norm(), 1e-9 * size * motion.norm());
    EXPECT_LT(std::abs(rest.score.dot(motion)), 1e-9 * score * motion.norm());
    for (const PatchScore& patch : rest.patches)
      EXPECT_LT(std::abs(patch.score.dot(motion)), 1e-9 * score * motion.norm());
  }
  const auto eigen = eigen_decomposition(rest.information);
  EXPECT_GT(eigen.eigenvalues()[2], 1e-6 * eigen.eigenvalues()[5]);  // The other four are held.
}

struct ClusterEntry {
  std::uint64_t patch;
  std::size_t view;
  RigidTangent score;
};

std::vector<ClusterEntry> entries_of(const ClusterScores& scores) {
  std::vector<ClusterEntry> all;
  scores.for_each_cluster([&](std::uint64_t patch, std::span<const ClusterScores::Entry> entries) {
    for (const auto& [view, score] : entries) all.push_back({patch, view, score});
  });
  return all;
}

TEST(ClusterScores, AddUpOverThePairsOfAView) {
  PairInformation first, second;
  first.source = 0;
  first.target = 1;
  first.patches = {{7, RigidTangent::Constant(1.0)}, {9, RigidTangent::Constant(2.0)}};
  second.source = 1;
  second.target = 2;
  second.patches = {{7, RigidTangent::Constant(4.0)}};
  ClusterScores scores(3);
  scores.add(first);
  scores.add(second);
  const auto entries = entries_of(scores);
  ASSERT_EQ(entries.size(), 5u);
  const std::uint64_t patches[] = {7, 7, 7, 9, 9};
  const std::size_t views[] = {0, 1, 2, 0, 1};
  const double expected[] = {1.0, 3.0, -4.0, 2.0, -2.0};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(entries[i].patch, patches[i]);
    EXPECT_EQ(entries[i].view, views[i]);
    EXPECT_TRUE(entries[i].score == RigidTangent::Constant(expected[i]));
  }
}

TEST(ClusterScores, AreInOrderWhateverTheOrderOfThePairs) {
  std::mt19937 generator(3);
  std::map<std::pair<std::uint64_t, std::size_t>, double> expected;
  ClusterScores scores(4);
  for (std::size_t i = 0; i < 30; ++i) {
    PairInformation pair;
    pair.source = i % 4;
    pair.target = (i + 1 + i / 4 % 3) % 4;
    for (std::uint64_t patch = 0; patch < 300; ++patch) {
      if (generator() % 3 != 0) continue;
      const double score = 1.0 + generator() % 5;
      pair.patches.push_back({patch, RigidTangent::Constant(score)});
      expected[{patch, pair.source}] += score;
      expected[{patch, pair.target}] -= score;
    }
    scores.add(pair);
  }
  std::vector<std::pair<std::pair<std::uint64_t, std::size_t>, double>> found;
  for (const auto& entry : entries_of(scores))
    found.push_back({{entry.patch, entry.view}, entry.score[3]});
  EXPECT_TRUE(std::ranges::equal(found, expected, [](const auto& a, const auto& b) {
    return a.first == b.first && a.second == b.second;
  }));
}

// The patch in column `x` of the row through the origin: see patch_of() in pair_information.cpp.
std::uint64_t patch_at(std::int64_t x) { return (static_cast<std::uint64_t>(x) & 0x1fffffU) << 42; }

TEST(ClusterScores, AddUpOnLargerPatches) {
  PairInformation pair;
  pair.target = 1;
  for (const std::int64_t x : {0, 3, 4, -1, -4, -5})
    pair.patches.push_back({patch_at(x), RigidTangent::Constant(1.0 + static_cast<double>(x))});
  ClusterScores scores(2);
  scores.add(pair);
  std::vector<double> of_source;
  for (const auto& entry : entries_of(scores.on_larger_clusters()))
    if (entry.view == 0) of_source.push_back(entry.score[0]);
  EXPECT_EQ(of_source, (std::vector<double>{5.0, 5.0, -4.0, -3.0}));  // 0 to 3, 4, -8 to -5, rest.
}

TEST(PoseGraphSystem, SeesErrorsThatReachFartherThanAPatch) {
  const Ring exact(4, 0.0), white(4);
  auto smooth = exact.truth;
  for (std::size_t i = 0; i < smooth.size(); ++i)
    testing::add_smooth_noise(smooth[i], 0.1 * exact.spacing(), 7,
                              static_cast<std::uint32_t>(i + 1));
  const auto variance_inflation = [&](const std::vector<RangeView>& views) {
    std::vector<ViewSurface> surfaces;
    for (const auto& view : views) surfaces.emplace_back(view);
    PairInformationOptions options;
    options.search.max_distance = 5.0 * exact.spacing();
    options.patch = 8.0 * exact.spacing();
    std::vector<PairInformation> all;
    ClusterScores scores(views.size());
    for (const auto& pair : pairs_of(exact)) {
      const auto samples = in_grid_order(surfaces[pair.a], 0);
      all.push_back(pair_information(surfaces[pair.a], surfaces[pair.b],
                                     views[pair.a].world_from_view, views[pair.b].world_from_view,
                                     samples, options));
      all.back().source = pair.a;
      all.back().target = pair.b;
      scores.add(all.back());
    }
    return PoseGraphSystem(pointers_to(surfaces), all, first_held(views.size()),
                           Eigen::Vector3d::Zero())
        .variance_inflation(scores);
  };
  EXPECT_LT(variance_inflation(white.truth), 1.3);
  EXPECT_GT(variance_inflation(smooth), 2.0);
}

TEST(PoseGraphRefinement, FindsExactPosesOfExactViews) {
  const Ring ring(1, 0.0);
  auto poses =
      poses_of(perturbed(ring.truth, Eigen::Vector3d::Zero(), 0.005, 0.3 * ring.spacing()));
  refine_pose_graph(pointers_to(ring.surfaces), pairs_of(ring), first_held(poses.size()),
                    options_for(ring), poses);
  for (const double error : mean_displacements(ring.truth, poses, poses_of(ring.truth)))
    EXPECT_LT(error, 0.005 * ring.spacing());
}

// As of a street: nearly all samples lie on what its length leaves alone, so their scatter is that
// of noise, and most of what holds the views along it is farther off than that.
testing::Surface corner_with_balls() {
  std::vector<testing::Surface> parts = {testing::plane({0, 0, 10}, {0, 0, -1}),
                                         testing::plane({0, 3, 0}, {0, -1, 0})};
  for (int i = 0; i < 4; ++i)
    parts.push_back(testing::sphere({-3.0 + 2.1 * i, 0.5 - 0.6 * (i % 2), 10.0}, 0.4));
  return [parts](const Ray& ray) {
    std::optional<testing::SurfaceHit> first;
    for (const auto& part : parts)
      if (const auto hit = part(ray); hit && (!first || hit->t < first->t)) first = hit;
    return first;
  };
}

TEST(PoseGraphRefinement, GoesOnWhileStepsMakeProgress) {
  const Camera camera = Camera::pinhole(160, 120, {150, 150, 79.5, 59.5});
  std::vector<RangeView> views;
  std::vector<RigidMotion> truth(2, RigidMotion::Identity());
  truth[1].translation() << 0.7, 0.1, 0.3;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    views.push_back(testing::render(corner_with_balls(), camera, truth[i]));
    testing::add_range_noise(views.back(), 0.01, static_cast<std::uint32_t>(i + 1));
  }
  const std::vector<ViewSurface> surfaces(views.begin(), views.end());
  const double spacing = surfaces[0].spacing();
  PoseGraphRefinementOptions options;
  options.search.max_distance = 5.0 * spacing;
  options.tolerance = 0.005 * spacing;
  auto poses = truth;
  poses[1].translation().x() += 4.0 * spacing;  // Of which six steps leave more than half.
  const auto refined =
      refine_pose_graph(pointers_to(surfaces), {{0, 1}}, {true, false}, options, poses);
  EXPECT_GT(refined.iterations, 7);
  EXPECT_LE(refined.last_motion, options.tolerance);
  EXPECT_LT((poses[1].translation() - truth[1].translation()).norm(), 0.1 * spacing);
}

// Poses of a disturbed ring after some renewals, with one view held.
std::vector<RigidMotion> refined_poses(const Ring& ring, const PoseGraphRefinementOptions& options,
                                       std::size_t held, int threads) {
  auto poses =
      poses_of(perturbed(ring.truth, Eigen::Vector3d::Zero(), 0.005, 0.3 * ring.spacing()));
  std::vector<bool> is_held(poses.size(), false);
  is_held[held] = true;
  on_threads(threads, [&] {
    refine_pose_graph(pointers_to(ring.surfaces), pairs_of(ring), is_held, options, poses);
  });
  return poses;
}

TEST(PoseGraphRefinement, DoesNotDependOnTheThreadCount) {
  const Ring ring(2);
  auto options = options_for(ring);
  options.max_iterations = 3;
  const auto one = refined_poses(ring, options, 0, 1), two = refined_poses(ring, options, 0, 2);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_TRUE(one[i].matrix() == two[i].matrix());
}

TEST(PoseGraphRefinement, ConvergesAlikeOnAnyThreadCountAndWithAnyHeldView) {
  const Ring ring(2);
  auto options = options_for(ring);
  options.tolerance = 1e-5 * ring.spacing();
  options.max_iterations = 30;
  const auto one = refined_poses(ring, options, 0, 1), two = refined_poses(ring, options, 0, 2),
             other = refined_poses(ring, options, 4, 2);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_TRUE(one[i].matrix() == two[i].matrix());
  for (const double difference : mean_displacements(ring.truth, one, other))
    EXPECT_LT(difference, 1e-3 * ring.spacing());
}

Eigen::MatrixXd covariance_but_of_the_first(const PoseCovariance& covariance, std::size_t views) {
  Eigen::MatrixXd all(6 * (views - 1), 6 * (views - 1));
  for (std::size_t a = 1; a < views; ++a)
    for (std::size_t b = 1; b < views; ++b)
      all.block<6, 6>(static_cast<Eigen::Index>(6 * (a - 1)),
                      static_cast<Eigen::Index>(6 * (b - 1))) = covariance.between(a, b);
  return all;
}

TEST(PoseGraphRefinement, LeavesHeldViewsWithoutVariance) {
  const Ring ring(3);
  auto poses = poses_of(ring.truth);
  const auto refined = refine_pose_graph(pointers_to(ring.surfaces), pairs_of(ring),
                                         first_held(poses.size()), options_for(ring), poses);
  EXPECT_TRUE(poses[0].matrix() == ring.truth[0].world_from_view.matrix());
  ASSERT_TRUE(refined.solved);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_TRUE(refined.covariance.between(0, i).isZero(0.0));
    EXPECT_TRUE(refined.covariance.between(i, 0).isZero(0.0));
  }
  const Eigen::MatrixXd free = covariance_but_of_the_first(refined.covariance, poses.size());
  EXPECT_TRUE(free.isApprox(free.transpose()));
  EXPECT_GT(eigen_decomposition(free).eigenvalues()[0], 0.0);
}

TEST(PoseGraphRefinement, TellsWhatItsSolverDid) {
  const Ring ring(3);
  auto poses = poses_of(ring.truth);
  const auto refined = refine_pose_graph(pointers_to(ring.surfaces), pairs_of(ring),
                                         first_held(poses.size()), options_for(ring), poses);
  ASSERT_EQ(refined.solves.size(), static_cast<std::size_t>(refined.iterations));
  for (const SolverSummary& solve : refined.solves) {
    EXPECT_EQ(solve.stage, SolverStage::kPoseGraph);
    EXPECT_EQ(solve.termination, SolverTermination::kConverged) << solve.message;
    EXPECT_GT(solve.initial_cost, solve.final_cost);
    EXPECT_GT(solve.final_cost, 0.0);
  }
}

// The squared error whitened by the whole reported covariance, per degree of freedom.
double whitened_error(std::uint32_t seed) {
  const Ring ring(seed);
  const auto start =
      poses_of(perturbed(ring.truth, Eigen::Vector3d::Zero(), 0.01, ring.spacing(), seed));
  std::vector<ViewRole> roles(start.size(), ViewRole::kFree);
  roles[0] = ViewRole::kFixed;
  const auto refined = refine_jointly(ring.surfaces, start, roles);
  const auto free = static_cast<Eigen::Index>(6 * (start.size() - 1));
  Eigen::VectorXd error(free);
  for (std::size_t i = 1; i < start.size(); ++i) {
    const RigidMotion &estimate = refined->world_from_view[i],
                      &truth = ring.truth[i].world_from_view;
    const Eigen::AngleAxisd turn(estimate.linear() * truth.linear().transpose());
    const Eigen::Vector3d c = ring.surfaces[i].centre();
    error.segment<6>(static_cast<Eigen::Index>(6 * (i - 1))) << turn.angle() * turn.axis(),
        estimate * c - truth * c;
  }
  const Eigen::MatrixXd covariance =
      covariance_but_of_the_first(refined->joint_covariance, start.size());
  return error.dot(solve_symmetric(covariance, error)) / static_cast<double>(free);
}

// A sample of what relief_pose_accuracy measures over a hundred runs.
TEST(PoseGraphRefinement, ReportsTheCovarianceThatErrorsHave) {
  constexpr int kRuns = 4;
  double sum = 0.0;
  for (std::uint32_t seed = 1; seed <= kRuns; ++seed) sum += whitened_error(10 * seed);
  EXPECT_GT(sum / kRuns, 0.5);
  EXPECT_LT(sum / kRuns, 1.8);
}

}  // namespace
}  // namespace relief::registration
