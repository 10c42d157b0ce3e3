#include "registration/icp.h"

#include <numbers>

#include <gtest/gtest.h>

#include "registration/plane_step.h"
#include "tests/registration/bumpy_object.h"

namespace relief {
namespace {

struct Pair {
  explicit Pair(double noise) : views(testing::ring_of_views({.views = 8, .noise = noise})) {}

  RigidMotion truth() const {
    return views[0].world_from_view.inverse() * views[1].world_from_view;
  }
  // The truth turned about the object's centre and shifted.
  RigidMotion guess(double angle, double shift) const {
    const auto moved =
        testing::perturbed({views[0], views[1]}, Eigen::Vector3d::Zero(), angle, shift);
    return moved[0].world_from_view.inverse() * moved[1].world_from_view;
  }
  double error(const RigidMotion& found) const {
    double sum = 0.0, count = 0.0;
    for (int v = 0; v < views[1].height(); ++v)
      for (int u = 0; u < views[1].width(); ++u)
        if (views[1].has_sample(u, v)) {
          const Eigen::Vector3d p = views[1].point(u, v);
          sum += (found * p - truth() * p).norm();
          count += 1.0;
        }
    return sum / count / target.spacing();
  }

  std::vector<RangeView> views;
  ViewSurface target{views[0], {.neighbour_index = true}};
  ViewSurface source{views[1], {.neighbour_index = true}};
};

TEST(Icp, FindsThePoseOfExactViews) {
  const Pair pair(0.0);
  for (const auto objective : {IcpObjective::kPointToPlane, IcpObjective::kSymmetric}) {
    for (const auto association : {Association::kProjective, Association::kNearest}) {
      IcpOptions options;
      options.objective = objective;
      options.association = association;
      const auto found = align_pair(pair.source, pair.target, pair.guess(0.08, 3.0), options);
      EXPECT_EQ(found.termination, IcpTermination::kConverged);
      EXPECT_LT(pair.error(found.target_from_source), 0.05);
      EXPECT_GT(found.overlap, 0.4);
      EXPECT_TRUE(found.degenerate_directions.empty());
      EXPECT_NEAR(found.target_from_source.linear().determinant(), 1.0, 1e-12);
    }
  }
}

TEST(Icp, ErrorAgreesWithItsCovariance) {
  const Pair pair(0.3);
  const auto found = align_pair(pair.source, pair.target, pair.guess(0.04, 2.0));
  EXPECT_LT(pair.error(found.target_from_source), 0.2);
  // In standard deviations, over the six directions.
  const Eigen::Translation3d to_centre(-found.covariance_centre);
  const RigidMotion error =
      to_centre * pair.truth() * found.target_from_source.inverse() * to_centre.inverse();
  const Eigen::AngleAxisd turn(error.linear());
  Vector6d tangent;
  tangent << turn.angle() * turn.axis(), error.translation();
  const double mahalanobis = std::sqrt(tangent.dot(found.covariance.ldlt().solve(tangent)) / 6.0);
  EXPECT_LT(mahalanobis, 4.0);
  EXPECT_GT(mahalanobis, 0.1);
}

TEST(Icp, ReportsViewsThatDoNotOverlap) {
  const Pair pair(0.0);
  const RigidMotion apart = Eigen::Translation3d(500, 0, 0) * pair.truth();
  const auto found = align_pair(pair.source, pair.target, apart);
  EXPECT_EQ(found.termination, IcpTermination::kNoOverlap);
  EXPECT_FALSE(found.usable());
  EXPECT_TRUE(found.target_from_source.isApprox(apart));
}

TEST(Icp, NeverMovesAPlaneAlongItself) {
  const Camera camera = Camera::pinhole(80, 60, {100, 100, 39.5, 29.5});
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0.2, 0, -1}), camera);
  testing::add_range_noise(view, 0.02, 3);
  RangeView other = testing::render(testing::plane({0, 0, 10}, {0.2, 0, -1}), camera);
  testing::add_range_noise(other, 0.02, 4);
  const ViewSurface target(view), source(other);
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, 0, -1).normalized();
  const Eigen::Vector3d across = normal.unitOrthogonal();
  const RigidMotion guess(Eigen::Translation3d(0.3 * normal + 0.4 * across));
  const auto found = align_pair(source, target, guess);
  EXPECT_EQ(found.degenerate_directions.size(), 3u);
  const Eigen::Vector3d moved = found.target_from_source * source.centre() - source.centre();
  EXPECT_NEAR(moved.dot(normal), 0.0, 0.01);
  EXPECT_NEAR(moved.dot(across), 0.4, 0.01);
  EXPECT_GT(found.covariance.diagonal().tail<3>().maxCoeff(), 1.0);
}

TEST(PlaneStep, OfASmallMotionUndoesIt) {
  RigidTangent tangent;
  tangent << 0.01, -0.02, 0.015, 0.1, 0.05, -0.2;
  const RigidMotion motion = motion_from_tangent(tangent);
  for (const auto objective : {IcpObjective::kPointToPlane, IcpObjective::kSymmetric}) {
    RigidMotion rest = motion.inverse();
    for (int round = 0; round < 6; ++round) {
      std::vector<PlanePair> pairs;
      std::srand(1);
      for (int i = 0; i < 100; ++i) {
        const Eigen::Vector3d n = Eigen::Vector3d::Random().normalized();
        const Eigen::Vector3d p = 10 * Eigen::Vector3d::Random();
        pairs.push_back({rest * p, p, rest.linear() * n, n, n});
      }
      rest = solve_plane_step(pairs, {}, objective, 1e-4).motion * rest;
    }
    EXPECT_TRUE(rest.isApprox(RigidMotion::Identity(), 1e-12));
  }
}

}  // namespace
}  // namespace relief
