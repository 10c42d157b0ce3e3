#include "registration/pairwise/icp.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "registration/pairwise/plane_step.h"
#include "scan/base/linear_algebra.h"
#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

struct Pair {
  explicit Pair(double noise) : views(testing::ring_of_views({.pixels = 160, .noise = noise})) {}

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

TEST(Icp, IsPreciseInNoise) {
  const Pair pair(0.3);
  const auto found = align_pair(pair.source, pair.target, pair.guess(0.04, 2.0));
  EXPECT_LT(pair.error(found.target_from_source), 0.1);
}

// The squared error whitened by the reported covariance, per degree of freedom.
double whitened_error(const IcpResult& found, const RigidMotion& truth) {
  const Eigen::Translation3d to_centre(-found.covariance_centre);
  const RigidMotion error =
      to_centre * truth * found.target_from_source.inverse() * to_centre.inverse();
  const Eigen::AngleAxisd turn(error.linear());
  Vector6d tangent;
  tangent << turn.angle() * turn.axis(), error.translation();
  return tangent.dot(solve_symmetric(found.covariance, tangent)) / 6.0;
}

TEST(Icp, ReportsTheCovarianceThatErrorsHave) {
  constexpr std::uint32_t kRuns = 60;
  const auto exact = testing::ring_of_views({.views = 8, .pixels = 256, .noise = 0.0});
  const RigidMotion truth = exact[0].world_from_view.inverse() * exact[1].world_from_view;
  const double sigma = 0.3 * sample_spacing(exact[0]);
  double sum = 0.0;
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    RangeView a = exact[0], b = exact[1];
    testing::add_range_noise(a, sigma, 2 * run + 1);
    testing::add_range_noise(b, sigma, 2 * run + 2);
    const auto found = align_pair(ViewSurface(b), ViewSurface(a), truth);
    ASSERT_TRUE(found.usable());
    sum += whitened_error(found, truth);
  }
  EXPECT_GT(sum / kRuns, 0.7);
  EXPECT_LT(sum / kRuns, 1.4);
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

// A view of the mirrored object fits no rotation of it: whatever comes out is no reflection.
TEST(Icp, NeverReturnsAReflection) {
  const Pair pair(0.3);
  RangeView mirrored = pair.views[1];
  for (int v = 0; v < mirrored.height(); ++v) {
    for (int u = 0; u < mirrored.width(); ++u) {
      const int other = mirrored.width() - 1 - u;
      mirrored.range(u, v) = pair.views[1].range(other, v);
      mirrored.normals(u, v) =
          pair.views[1].normals(other, v).cwiseProduct(Eigen::Vector3f(-1, 1, 1));
    }
  }
  const auto found = align_pair(ViewSurface(mirrored), pair.target, pair.truth());
  EXPECT_NEAR(found.target_from_source.linear().determinant(), 1.0, 1e-12);
}

TEST(Icp, AlignsAViewWithItsDuplicate) {
  const Pair pair(0.3);
  const RigidMotion off(Eigen::Translation3d(0.5, -0.3, 0.2) *
                        Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitX()));
  const auto found = align_pair(pair.target, pair.target, off);
  EXPECT_EQ(found.termination, IcpTermination::kConverged);
  EXPECT_TRUE(found.target_from_source.isApprox(RigidMotion::Identity(), 1e-5));
}

TEST(Icp, OfASingleCommonSampleIsNoOverlap) {
  const Pair pair(0.0);
  RangeView one = pair.views[1];
  for (int v = 0; v < one.height(); ++v)
    for (int u = 0; u < one.width(); ++u)
      if (std::max(std::abs(u - 80), std::abs(v - 80)) > 2) one.range(u, v) = kNoSample;
  const ViewSurface source(one, {.boundary_margin = 2});
  ASSERT_EQ(source.samples().size(), 1u);
  EXPECT_FALSE(align_pair(source, pair.target, pair.truth()).usable());
}

// A million spacings from the view's own origin, as line scanners on rails have it.
TEST(Icp, LosesNothingFarFromTheOrigin) {
  const Camera near = Camera::orthographic(90, 90, {-45, -45, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  const Camera far =
      Camera::orthographic(90, 90, {1e6 - 45, -1e6 - 45, 3e5}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  const auto surface = testing::bumpy_object(50.0, {0, 0, 100});
  RangeView a = testing::render(surface, near);
  RangeView b = testing::render(surface, near,
                                RigidMotion(Eigen::Translation3d(0, 0, 100) *
                                            Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()) *
                                            Eigen::Translation3d(0, 0, -100)));
  testing::add_range_noise(a, 0.3, 1);
  testing::add_range_noise(b, 0.3, 2);
  const RigidMotion guess = b.world_from_view * Eigen::Translation3d(0.8, -0.5, 0.3);
  const auto here = align_pair(ViewSurface(b), ViewSurface(a), guess);
  a.camera = b.camera = far;
  const Eigen::Translation3d shift(1e6, -1e6, 3e5);
  const auto there =
      align_pair(ViewSurface(b), ViewSurface(a), RigidMotion(shift * guess * shift.inverse()));
  const RigidMotion back = shift.inverse() * there.target_from_source * shift;
  EXPECT_LT(
      (back * Eigen::Vector3d(0, 0, 100) - here.target_from_source * Eigen::Vector3d(0, 0, 100))
          .norm(),
      1e-4);
  EXPECT_LT(rotation_angle(back * here.target_from_source.inverse()), 1e-6);
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
}  // namespace relief::registration
