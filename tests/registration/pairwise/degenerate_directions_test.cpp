#include "registration/pairwise/degenerate_directions.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace relief::registration {
namespace {

using ::testing::StartsWith;

// A grid of parameters mapped to a surface.
template <typename Map>
std::vector<OrientedPoint> sampled(const Map& map) {
  std::vector<OrientedPoint> points;
  for (int i = 0; i <= 40; ++i)
    for (int j = 0; j <= 40; ++j) points.push_back(map(i / 40.0, j / 40.0));
  return points;
}

// How much the surface moves along its normals under a unit of the motion.
double normal_motion(const std::vector<OrientedPoint>& points, const DegenerateDirection& d) {
  double largest = 0.0;
  for (const auto& p : points) {
    const Eigen::Vector3d velocity =
        d.motion.head<3>().cross(p.point - d.centre) + d.motion.tail<3>();
    largest = std::max(largest, std::abs(velocity.dot(p.normal)));
  }
  return largest;
}

std::vector<OrientedPoint> plane() {
  return sampled([](double a, double b) {
    return OrientedPoint{{100 + 8 * a, 5 * b, 3}, {0, 0, 1}};
  });
}

std::vector<OrientedPoint> sphere_cap() {
  return sampled([](double a, double b) {
    const double z = 0.3 + 0.7 * a, r = std::sqrt(1 - z * z), phi = 2 * std::numbers::pi * b;
    const Eigen::Vector3d n(r * std::cos(phi), r * std::sin(phi), z);
    return OrientedPoint{Eigen::Vector3d(10, 20, 30) + 4 * n, n};
  });
}

std::vector<OrientedPoint> cylinder() {
  return sampled([](double a, double b) {
    const double phi = std::numbers::pi * b;
    const Eigen::Vector3d n(std::cos(phi), 0, std::sin(phi));
    return OrientedPoint{Eigen::Vector3d(0, 10 * a, 0) + 3 * n, n};
  });
}

TEST(DegenerateDirections, OfAPlaneIsTwoSlidesAndATurn) {
  const auto points = plane();
  const auto directions = degenerate_directions(analyse_constraints(points), 1e-4);
  ASSERT_EQ(directions.size(), 3u);
  EXPECT_THAT(directions[0].description, StartsWith("sliding along"));
  EXPECT_THAT(directions[1].description, StartsWith("sliding along"));
  EXPECT_THAT(directions[2].description, StartsWith("turning about"));
  for (const auto& d : directions) EXPECT_LT(normal_motion(points, d), 1e-9);
}

TEST(DegenerateDirections, OfASphereIsEveryTurnAboutItsCentre) {
  const auto points = sphere_cap();
  const auto directions = degenerate_directions(analyse_constraints(points), 1e-4);
  ASSERT_EQ(directions.size(), 3u);
  for (const auto& d : directions) {
    EXPECT_THAT(d.description, StartsWith("turning about"));
    EXPECT_LT(normal_motion(points, d), 1e-9);
  }
}

TEST(DegenerateDirections, OfACylinderIsASlideAndATurn) {
  const auto directions = degenerate_directions(analyse_constraints(cylinder()), 1e-4);
  ASSERT_EQ(directions.size(), 2u);
  const Eigen::Vector3d slide = directions[0].motion.tail<3>().normalized();
  EXPECT_NEAR(std::abs(slide.y()), 1.0, 1e-6);
  EXPECT_LT(directions[0].motion.head<3>().norm(), 1e-6);
  EXPECT_THAT(directions[1].description, StartsWith("turning about"));
}

TEST(DegenerateDirections, OfAnEllipsoidIsNone) {
  const auto ellipsoid = sampled([](double a, double b) {
    const double z = 2 * a - 1, r = std::sqrt(std::max(0.0, 1 - z * z));
    const double phi = 2 * std::numbers::pi * b;
    const Eigen::Vector3d s(r * std::cos(phi), r * std::sin(phi), z), axes(3, 4, 6);
    return OrientedPoint{axes.cwiseProduct(s), s.cwiseQuotient(axes).normalized()};
  });
  EXPECT_TRUE(degenerate_directions(analyse_constraints(ellipsoid), 1e-3).empty());
}

TEST(DegenerateDirections, StiffnessDoesNotDependOnUnitOrPlace) {
  auto points = sphere_cap();
  const auto before = analyse_constraints(points);
  for (auto& p : points) p.point = 1000.0 * p.point + Eigen::Vector3d(1e6, 0, -1e6);
  const auto after = analyse_constraints(points);
  EXPECT_LT((before.eigenvalues - after.eigenvalues).norm(), 1e-8);
}

TEST(DegenerateDirections, FewPointsHoldNothing) {
  const std::vector<OrientedPoint> few(5, {{1, 2, 3}, {0, 0, 1}});
  EXPECT_EQ(degenerate_directions(analyse_constraints(few), 1e-4).size(), 6u);
  const std::vector<OrientedPoint> equal(50, {{1, 2, 3}, {0, 0, 1}});
  EXPECT_EQ(degenerate_directions(analyse_constraints(equal), 1e-4).size(), 6u);
}

// The normals with noise of `size` radians, of their own in each call.
std::vector<Eigen::Vector3d> noisy_normals(const std::vector<OrientedPoint>& points, double size,
                                           unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> noise(0.0, size);
  std::vector<Eigen::Vector3d> normals;
  for (const auto& p : points)
    normals.push_back(
        (p.normal + Eigen::Vector3d(noise(generator), noise(generator), noise(generator)))
            .normalized());
  return normals;
}

std::vector<OrientedPoint> with_normals(std::vector<OrientedPoint> points,
                                        const std::vector<Eigen::Vector3d>& normals) {
  for (std::size_t i = 0; i < points.size(); ++i) points[i].normal = normals[i];
  return points;
}

TEST(SharedConstraints, IsThatOfEitherSurfaceWhereBothShowTheSame) {
  const auto points = sampled([](double a, double b) {
    const double tilt = 0.2 * std::sin(20 * a) * std::cos(15 * b);
    return OrientedPoint{{8 * a, 5 * b, 0.3 * b * b},
                         Eigen::Vector3d(tilt, 0.3 * b, 1).normalized()};
  });
  std::vector<Eigen::Vector3d> same;
  for (const auto& p : points) same.push_back(p.normal);
  const auto shared = shared_constraints(points, same);
  const auto own = analyse_constraints(points);
  EXPECT_LT((shared.spectrum.eigenvalues - own.eigenvalues).norm(), 1e-12);
  EXPECT_LT((shared.correlations - Vector6d::Ones()).norm(), 1e-9);
  EXPECT_TRUE(directions_without_shared_relief(shared).empty());
}

// Noise holds the cylinder where one surface is looked at, and not where both are.
TEST(SharedConstraints, HasNoNoise) {
  const auto points = cylinder();
  const auto of_a = with_normals(points, noisy_normals(points, 0.1, 1));
  EXPECT_GT(analyse_constraints(of_a).eigenvalues[0], 0.005);
  const auto shared = shared_constraints(of_a, noisy_normals(points, 0.1, 2));
  EXPECT_LT(std::abs(shared.spectrum.eigenvalues[0]), 0.001);
  EXPECT_LT(shared.correlations[0], 0.1);
  EXPECT_EQ(directions_without_shared_relief(shared).size(), 2u);  // Along the axis and about it.
}

TEST(SharedConstraints, KeepsReliefBelowTheNoise) {
  const auto points = sampled([](double a, double b) {
    const double phi = std::numbers::pi * b;
    const double along = 0.15 * std::sin(9 * a + 4 * b), round = 0.15 * std::cos(11 * b - 5 * a);
    const Eigen::Vector3d n(std::cos(phi + round), along, std::sin(phi + round));
    return OrientedPoint{{3 * std::cos(phi), 10 * a, 3 * std::sin(phi)}, n.normalized()};
  });
  const double relief = analyse_constraints(points).eigenvalues[0];
  const auto shared = shared_constraints(with_normals(points, noisy_normals(points, 0.1, 1)),
                                         noisy_normals(points, 0.1, 2));
  EXPECT_NEAR(shared.spectrum.eigenvalues[0], relief, 0.15 * relief);
  EXPECT_NEAR(shared.correlations[0], relief / (relief + 0.01), 0.15);
}

TEST(SharedConstraints, CanBeSummedAboutAnyCentre) {
  const auto points = cylinder();
  const auto normals = noisy_normals(points, 0.1, 2);
  const Eigen::Vector3d centre(3.0, -20.0, 8.0);
  SharedConstraintSum about_origin(Eigen::Vector3d(1.0, 2.0, 3.0), 0.7), direct(centre, 12.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    about_origin.add(points[i], normals[i]);
    direct.add(points[i], normals[i]);
  }
  const auto moved = about_origin.about(centre, 12.0).constraints(),
             expected = direct.constraints();
  EXPECT_EQ(moved.spectrum.centre, centre);
  EXPECT_EQ(moved.spectrum.radius, 12.0);
  EXPECT_LT((moved.spectrum.eigenvalues - expected.spectrum.eigenvalues).norm(), 1e-11);
  EXPECT_LT((moved.correlations - expected.correlations).norm(), 1e-8);
}

TEST(SharedConstraints, OfFewPointsIsNothing) {
  const std::vector<OrientedPoint> few(5, {{1, 2, 3}, {0, 0, 1}});
  const auto shared = shared_constraints(few, std::vector<Eigen::Vector3d>(5, {0, 0, 1}));
  EXPECT_TRUE(shared.correlations.isZero(0.0));
}

// Sums of parts about one centre are those of the whole.
TEST(SharedConstraints, AddUp) {
  const auto points = cylinder();
  const auto normals = noisy_normals(points, 0.1, 2);
  const Eigen::Vector3d centre(1, 2, 3);
  SharedConstraintSum whole(centre, 2.0), first(centre, 2.0), second(centre, 2.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    whole.add(points[i], normals[i]);
    (i % 3 == 0 ? first : second).add(points[i], normals[i]);
  }
  first.add(second);
  EXPECT_LT(
      (whole.constraints().spectrum.eigenvalues - first.constraints().spectrum.eigenvalues).norm(),
      1e-12);
}

TEST(WithoutMotions, LeavesOutWhatLiesAlongThemAndKeepsTheRest) {
  DegenerateDirection along, about;
  along.motion << 0, 0, 0, 0, 3, 0;
  about.centre << 5, 0, -2;
  about.motion << 0, 0.5, 0, 0, 0, 0;
  const Eigen::Vector3d centre(1, 2, 3);
  const Matrix6d rest = without_motions({along, about}, centre, 9.0);
  EXPECT_LT((rest * rest - rest).norm(), 1e-12);
  EXPECT_LT((rest * tangent_about(centre, along)).norm(), 1e-12);
  EXPECT_LT((rest * tangent_about(centre, about)).norm(), 1e-12);
  Vector6d other;  // A turn that neither has a part of.
  other << 1, 0, 0, 0, 0, 0;
  EXPECT_LT((rest * other - other).norm(), 1e-12);
  EXPECT_TRUE(without_motions({}, centre, 9.0).isIdentity(0.0));
}

}  // namespace
}  // namespace relief::registration
