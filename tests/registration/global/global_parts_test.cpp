#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "registration/global/features/feature_matches.h"
#include "registration/global/features/local_features.h"
#include "registration/global/features/resampled_view.h"
#include "registration/global/features/view_similarity.h"
#include "registration/global/links/consistency_graph.h"
#include "registration/global/links/moved_piece.h"
#include "registration/global/links/shared_constraint.h"
#include "registration/global/pair_search.h"
#include "registration/global/robust_motion.h"
#include "registration/global/turntable.h"
#include "registration/verification/coherent_residual.h"
#include "registration/verification/pose_evidence.h"
#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

using ::testing::ElementsAre;
using ::testing::SizeIs;

const std::vector<RangeView>& ring() {
  static const auto views = testing::ring_of_views({.views = 8, .pixels = 128});
  return views;
}

const std::vector<ViewSurface>& surfaces() {
  static const auto list = [] {
    std::vector<ViewSurface> made;
    for (const auto& view : ring()) made.emplace_back(view);
    return made;
  }();
  return list;
}

RigidMotion true_motion(std::size_t a, std::size_t b) {
  return ring()[b].world_from_view.inverse() * ring()[a].world_from_view;
}

RigidMotion some_motion() {
  RigidTangent tangent;
  tangent << 0.4, -1.1, 0.7, 30.0, -20.0, 10.0;
  return motion_from_tangent(tangent);
}

ResampledView moved(const ResampledView& view, const RigidMotion& motion) {
  return {motion * view.points, motion.linear() * view.normals};
}

Eigen::Matrix3Xd random_points(Eigen::Index count, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-50.0, 50.0);
  Eigen::Matrix3Xd points(3, count);
  for (auto& x : points.reshaped()) x = uniform(generator);
  return points;
}

TEST(RobustMotion, IsTrueAmongSixtyPercentOfOutliers) {
  const Eigen::Matrix3Xd source = random_points(100, 1);
  Eigen::Matrix3Xd target = some_motion() * source;
  target.rightCols(60) = random_points(60, 2);
  const auto fit = fit_robustly(source, target, 0.5);
  EXPECT_THAT(fit.inliers, SizeIs(40));
  EXPECT_TRUE(fit.target_from_source.isApprox(some_motion(), 1e-9));
}

TEST(RobustMotion, OfTooFewPointsExplainsNone) {
  EXPECT_TRUE(fit_robustly(random_points(2, 1), random_points(2, 1), 0.5).inliers.empty());
  EXPECT_TRUE(fit_robustly({}, {}, 0.5).inliers.empty());
}

TEST(RobustMotion, IsNeverAReflection) {
  const Eigen::Matrix3Xd source = random_points(50, 3);
  Eigen::Matrix3Xd target = source;
  target.row(0) *= -1.0;
  EXPECT_GT(fit_robustly(source, target, 5.0).target_from_source.linear().determinant(), 0.0);
}

TEST(ResampledView, HasOnePointPerCellOnTheSurface) {
  const double cell = coarse_scale(surfaces()).cell;
  EXPECT_GE(cell, 2.9 * surfaces()[0].spacing());
  const auto view = resample(surfaces()[0], cell);
  EXPECT_GT(view.size(), 300);
  EXPECT_LT(view.size(), 4000);
  for (Eigen::Index i = 0; i < view.size(); ++i) {
    EXPECT_NEAR(view.normals.col(i).norm(), 1.0, 1e-9);
    const auto pixel = surfaces()[0].project(view.points.col(i));
    const auto seen = pixel ? surfaces()[0].at(*pixel) : std::nullopt;
    if (seen) {
      EXPECT_LT((seen->point - view.points.col(i)).dot(seen->normal), cell);
    }
  }
}

TEST(LocalFeatures, DoNotChangeWhenTheViewMoves) {
  const double cell = coarse_scale(surfaces()).cell;
  const auto here = resample(surfaces()[0], cell);
  const auto there = moved(here, some_motion());
  const LocalFeatures difference =
      compute_fpfh(here, 3 * cell, 6 * cell) - compute_fpfh(there, 3 * cell, 6 * cell);
  // Rounding moves an angle from one bin to the next now and then.
  EXPECT_LT(difference.cwiseAbs().mean(), 1e-3);
}

TEST(LocalFeatures, TellAViewFromItsMirrorImage) {
  const double cell = coarse_scale(surfaces()).cell;
  const auto view = resample(surfaces()[0], cell);
  ResampledView mirrored = view;
  mirrored.points.row(0) *= -1.0;
  mirrored.normals.row(0) *= -1.0;
  const LocalFeatures difference =
      compute_fpfh(view, 3 * cell, 6 * cell) - compute_fpfh(mirrored, 3 * cell, 6 * cell);
  EXPECT_GT(difference.cwiseAbs().mean(), 4e-3);
}

TEST(FeatureMatches, OfAViewWithItselfAreTheIdentity) {
  const double cell = coarse_scale(surfaces()).cell;
  const auto features = compute_fpfh(resample(surfaces()[0], cell), 3 * cell, 6 * cell);
  for (const auto& match : match_features(features, features, {.candidates = 1}))
    EXPECT_LT((features.col(match.a) - features.col(match.b)).norm(), 1e-6f);
  EXPECT_TRUE(match_features(features, LocalFeatures()).empty());
}

TEST(ConsistencyGraph, JoinsWhatOneMotionExplainsAndNoMirrorImage) {
  ResampledView a;
  a.points = random_points(30, 5);
  a.normals = random_points(30, 6).colwise().normalized();
  const ResampledView b = moved(a, some_motion());
  std::vector<FeatureMatch> matches;
  for (Eigen::Index i = 0; i < 30; ++i) matches.push_back({i, i});
  for (Eigen::Index i = 0; i < 30; ++i) matches.push_back({i, (i + 7) % 30});
  const ConsistencyOptions options{.distance_tolerance = 0.01, .least_distance = 1.0};
  const ConsistencyGraph graph(a, b, matches, options);
  const auto set = graph.consensus_around(0);
  EXPECT_THAT(set, SizeIs(30));
  EXPECT_EQ(set.back(), 29u);

  ResampledView mirrored = b;
  mirrored.points.row(0) *= -1.0;
  mirrored.normals.row(0) *= -1.0;
  matches.resize(30);
  const ConsistencyGraph none(a, mirrored, matches, options);
  std::size_t edges = 0;
  for (std::size_t i = 0; i < none.size(); ++i) edges += none.degree(i);
  EXPECT_LT(edges, 30u * 29u / 3u);  // Only where the volume is small.
}

TEST(PoseEvidence, IsForTheTruePoseAndAgainstOthers) {
  const auto &a = surfaces()[0], &b = surfaces()[1];
  const auto truth = judge_pose(a, b, true_motion(0, 1));
  EXPECT_TRUE(plausible(truth, a, b));
  EXPECT_EQ(truth.free_space_violation, 0.0);
  EXPECT_FALSE(truth.degenerate);
  EXPECT_LT(truth.coherent_rms, 0.1 * a.spacing());
  // Moved towards the sensor, the samples of a would have hidden those of b.
  const RigidMotion nearer =
      Eigen::Translation3d(20.0 * b.spacing() * b.mean_normal()) * true_motion(0, 1);
  const auto hiding = judge_pose(a, b, nearer);
  EXPECT_GT(hiding.free_space_violation, 0.3);
  EXPECT_TRUE(violates_free_space(hiding));
  const RigidMotion turned = true_motion(0, 1) * Eigen::Translation3d(a.centre()) *
                             Eigen::AngleAxisd(0.4, a.mean_normal()) *
                             Eigen::Translation3d(-a.centre());
  EXPECT_FALSE(plausible(judge_pose(a, b, turned), a, b));
}

TEST(PoseEvidence, OfViewsOfASphereSlides) {
  const Camera camera = Camera::pinhole(100, 100, {200, 200, 49.5, 49.5});
  const auto sphere = testing::sphere({0, 0, 0}, 40.0);
  const auto first = testing::render(sphere, camera, testing::look_at({200, 0, 0}, {0, 0, 0}));
  const auto second = testing::render(sphere, camera, testing::look_at({150, 130, 0}, {0, 0, 0}));
  const ViewSurface a(first), b(second);
  const auto evidence = judge_pose(a, b, second.world_from_view.inverse() * first.world_from_view);
  EXPECT_GT(evidence.overlap, 0.3);
  EXPECT_TRUE(evidence.degenerate);
}

// Noise that neighbours share, of `size` spacings. It is in the normals, and no estimate of noise
// between neighbours finds it.
RangeView with_smooth_noise(RangeView view, double size, double phase) {
  const double amplitude = size * sample_spacing(view);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      view.range(u, v) += amplitude * std::sin(u / 1.7 + phase) * std::cos(v / 1.9 + 2.3 * phase);
  return view;
}

// At the true pose.
bool is_degenerate(const RangeView& first, const RangeView& second) {
  const std::vector<RangeView> views{first, second};
  std::vector<ViewSurface> surfaces;
  for (const RangeView& view : views) surfaces.emplace_back(view);
  const RigidMotion truth = second.world_from_view.inverse() * first.world_from_view;
  const PoseHypothesis pose{truth, judge_pose(surfaces[0], surfaces[1], truth)};
  EXPECT_GT(pose.evidence.overlap, 0.3);
  return pose.evidence.degenerate ||
         lacks_shared_constraint(surfaces[0], surfaces[1], pose, coarse_scale(surfaces), {});
}

TEST(LacksSharedConstraint, OnASphereThoughNoiseThatNeighboursShareHoldsIt) {
  const Camera camera = Camera::pinhole(100, 100, {200, 200, 49.5, 49.5});
  const auto sphere = testing::sphere({0, 0, 0}, 40.0);
  const auto first = testing::render(sphere, camera, testing::look_at({200, 0, 0}, {0, 0, 0}));
  const auto second = testing::render(sphere, camera, testing::look_at({150, 130, 0}, {0, 0, 0}));
  EXPECT_TRUE(is_degenerate(first, second));
  const auto noisy = with_smooth_noise(first, 0.5, 0.3),
             other = with_smooth_noise(second, 0.5, 1.9);
  const ViewSurface a(noisy), b(other);
  const RigidMotion truth = second.world_from_view.inverse() * first.world_from_view;
  EXPECT_FALSE(judge_pose(a, b, truth).degenerate);
  EXPECT_TRUE(is_degenerate(noisy, other));
}

TEST(LacksSharedConstraint, NotOnRelief) {
  EXPECT_FALSE(is_degenerate(ring()[0], ring()[1]));
  EXPECT_FALSE(is_degenerate(with_smooth_noise(ring()[0], 0.5, 0.3),
                             with_smooth_noise(ring()[1], 0.5, 1.9)));
}

TEST(PoseEvidence, MissesWhatTheOtherSensorShouldHaveSeen) {
  EXPECT_FALSE(misses_coverage(judge_pose(surfaces()[0], surfaces()[1], true_motion(0, 1))));
  // A view that measured only the middle of its image: nothing there fits badly, but the rest of
  // the other view faces it and was not seen.
  RangeView middle = ring()[0];
  for (int v = 0; v < middle.height(); ++v)
    for (int u = 0; u < middle.width(); ++u)
      if (std::hypot(u - 64, v - 64) > 24) middle.range(u, v) = kNoSample;
  const ViewSurface part(middle);
  const auto evidence = judge_pose(surfaces()[0], part, RigidMotion::Identity());
  EXPECT_TRUE(plausible(evidence, surfaces()[0], part));
  EXPECT_GT(evidence.missing, 0.15);
  EXPECT_TRUE(misses_coverage(evidence));
}

TEST(CoherentRms, KeepsWhatIsAlikeBeyondTheNoise) {
  Eigen::Matrix3Xd points = random_points(2000, 8);
  points.row(2).setZero();
  const double extent = points.cwiseAbs().maxCoeff();
  points *= 50.0 / extent;
  std::mt19937 generator(4);
  std::normal_distribution<double> normal;
  std::vector<double> noise, blocks, smooth;
  std::map<std::pair<long, long>, double> of_block;  // Alike within squares of side 2.
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    noise.push_back(normal(generator));
    blocks.push_back(
        of_block
            .try_emplace({std::lround(points(0, i) / 2), std::lround(points(1, i) / 2)},
                         normal(generator))
            .first->second);
    smooth.push_back(std::sin(0.1 * points(0, i)));
  }
  EXPECT_LT(coherent_rms(points, noise, {3.0, 10.0}), 0.15);
  EXPECT_LT(coherent_rms(points, blocks, {3.0, 10.0}), 0.25);
  EXPECT_GT(coherent_rms(points, blocks, {0.0, 2.0}), 0.5);
  EXPECT_NEAR(coherent_rms(points, smooth, {3.0, 10.0}), std::sqrt(0.5), 0.15);
  EXPECT_EQ(coherent_rms({}, {}, {1.0, 2.0}), 0.0);
}

TEST(CoherentRms, CountsEachPairOfPointsOnce) {
  const Eigen::Matrix3Xd points = random_points(700, 5);
  const double extent = points.cwiseAbs().maxCoeff();
  std::mt19937 generator(6);
  std::normal_distribution<double> normal(0.5);
  std::vector<double> residuals;
  for (Eigen::Index i = 0; i < points.cols(); ++i) residuals.push_back(normal(generator));
  for (const DistanceBand& band : {DistanceBand{0.0, 0.1}, {0.05, 0.4}, {0.0, 3.0}}) {
    double products = 0.0, pairs = 0.0;
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      for (Eigen::Index j = 0; j < i; ++j) {
        const double distance = (points.col(i) - points.col(j)).norm() / extent;
        if (distance < band.nearest || distance > band.farthest) continue;
        products += residuals[static_cast<std::size_t>(i)] * residuals[static_cast<std::size_t>(j)];
        ++pairs;
      }
    }
    ASSERT_GT(products, 0.0);
    EXPECT_NEAR(coherent_rms(points / extent, residuals, band), std::sqrt(products / pairs), 1e-12);
  }
}

TEST(PairSearch, FindsTheTruePoseOfNeighbours) {
  const auto scale = coarse_scale(surfaces());
  const auto a = prepare_coarse_view(surfaces()[2], scale);
  const auto b = prepare_coarse_view(surfaces()[3], scale);
  std::vector<PoseHypothesis> good;
  for (const auto& hypothesis : search_pair(a, b, scale))
    if (plausible(hypothesis.evidence, surfaces()[2], surfaces()[3])) good.push_back(hypothesis);
  ASSERT_FALSE(good.empty());
  EXPECT_TRUE(
      same_pose(surfaces()[2], good[0].b_from_a, true_motion(2, 3), surfaces()[2].spacing()));
}

// Six views of a sixteenth of a turn each; the first three are placed.
TEST(TurntableLinks, GoOnWithTheStepsThatAreKnownAndCloseLoops) {
  auto views = testing::ring_of_views({.views = 16, .pixels = 128, .tilts = {0.2, 0.2}});
  views.resize(6);
  std::vector<ViewSurface> of_views;
  ViewGroups groups = ViewGroups::singles(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    of_views.emplace_back(views[i]);
    if (i > 2) continue;
    groups.group[i] = 0;
    groups.group_from_view[i] = views[i].world_from_view;
  }
  std::map<std::pair<std::size_t, std::size_t>, int> found;
  for (const PoseLink& link : turntable_links(of_views, groups, {}, {})) {
    const RigidMotion truth =
        views[link.b].world_from_view.inverse() * views[link.a].world_from_view;
    const ViewSurface& view = of_views[link.a];
    if (same_pose(view, link.b_from_a, truth, view.spacing())) ++found[{link.a, link.b}];
  }
  using Pair = std::pair<std::size_t, std::size_t>;
  for (const Pair& pair : {Pair{2, 3}, {3, 4}, {4, 5}, {1, 3}, {2, 4}, {3, 5}})
    EXPECT_GT(found[pair], 0) << pair.first << ' ' << pair.second;
}

TEST(ViewSimilarity, RanksNeighboursBeforeOpposites) {
  const auto scale = coarse_scale(surfaces());
  std::vector<CoarseView> views;
  for (const auto& surface : surfaces()) views.push_back(prepare_coarse_view(surface, scale));
  std::vector<const LocalFeatures*> features;
  for (const auto& view : views) features.push_back(&view.features);
  const auto pairs = rank_pairs(features);
  EXPECT_THAT(pairs, SizeIs(28));
  std::size_t neighbours = 0;
  for (std::size_t k = 0; k < 8; ++k) {
    const std::size_t apart = pairs[k].second - pairs[k].first;
    neighbours += apart <= 2 || apart >= 6 ? 1 : 0;
  }
  EXPECT_GE(neighbours, 5u);
  const LocalFeatures none;
  EXPECT_THAT(rank_pairs({&none, &none}), ElementsAre(std::pair<std::size_t, std::size_t>(0, 1)));
}

// A board, and a ball before it that a camera which stands still sees elsewhere in the second view.
TEST(MovedPiece, TellsWhatMovedBeforeASensorThatStoodStill) {
  const Camera camera = Camera::pinhole(160, 120, {200, 200, 79.5, 59.5});
  const auto view_with_ball_at = [&](double x, std::uint32_t seed) {
    const auto ball = testing::sphere({x, 0, 85}, 4);
    const auto board = testing::plane({0, 0, 100}, {0.2, 0.1, -1});
    RangeView view = testing::render(
        [&](const Ray& ray) {
          const auto hit = ball(ray);
          return hit ? hit : board(ray);
        },
        camera);
    testing::add_range_noise(view, 0.1, seed);
    return view;
  };
  const RangeView view = view_with_ball_at(0, 1), same = view_with_ball_at(0, 2),
                  moved = view_with_ball_at(10, 3);
  const ViewSurface a(view), b(same), c(moved);
  const RigidMotion still = RigidMotion::Identity();
  EXPECT_FALSE(moved_before_still_sensor(a, b, still));
  EXPECT_TRUE(moved_before_still_sensor(a, c, still));
  EXPECT_TRUE(moved_before_still_sensor(c, a, still));
  const RigidMotion elsewhere(Eigen::Translation3d(10.0 * a.spacing(), 0, 0));
  EXPECT_FALSE(moved_before_still_sensor(a, c, elsewhere));
}

}  // namespace
}  // namespace relief::registration
