#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "relief/evaluation/mesh_errors.h"
#include "relief/scan/rigid_motion.h"
#include "scan/simulation/objects/geodesic_sphere.h"
#include "tests/support/result_matchers.h"

namespace relief::evaluation {
namespace {

TriangleMesh sphere(double radius, int divisions = 100) {
  TriangleMesh mesh = simulation::geodesic_sphere(divisions);
  for (auto& vertex : mesh.vertices) vertex *= radius;
  return mesh;
}

// [0, size] x [0, size] at a height, seen from above.
TriangleMesh square(double size, double height) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, height}, {size, 0, height}, {size, size, height}, {0, size, height}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TriangleMesh box() {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  mesh.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

void expect_all_equal(const ErrorStatistics& statistics, double expected, double tolerance) {
  EXPECT_NEAR(statistics.mean, expected, tolerance);
  EXPECT_NEAR(statistics.median, expected, tolerance);
  EXPECT_NEAR(statistics.rms, expected, tolerance);
  EXPECT_NEAR(statistics.p95, expected, tolerance);
  EXPECT_NEAR(statistics.max, expected, tolerance);
}

TEST(CompareMeshes, AThickerSphereIsOffByTheThicknessInEveryStatistic) {
  const double e = 0.01;
  const auto comparison = value_of(compare_meshes(
      sphere(1.0 + e), sphere(1.0), {.samples = 20000, .thresholds = {0.009, 0.011}}));
  expect_all_equal(comparison.accuracy.all.distance, e, 1e-4 * e);
  expect_all_equal(comparison.completeness.all.distance, e, 1e-4 * e);
  EXPECT_EQ(comparison.accuracy.all.distance.count, 20000u);
  EXPECT_LT(comparison.accuracy.all.normals_deg.max, 0.05);
  EXPECT_EQ(comparison.f_score[0], 0.0);
  EXPECT_EQ(comparison.f_score[1], 1.0);
  EXPECT_FALSE(comparison.accuracy.measured);
}

TEST(CompareMeshes, KeepsEveryDistanceWithItsSign) {
  const auto outer = compare_meshes(sphere(1.02, 30), sphere(1.0, 30), {.samples = 2000});
  const auto inner = compare_meshes(sphere(0.98, 30), sphere(1.0, 30), {.samples = 2000});
  ASSERT_TRUE(outer && inner);
  ASSERT_EQ(outer->signed_accuracy.size(), 2000u);
  ASSERT_EQ(outer->completeness_distances.size(), 2000u);
  for (const double error : outer->signed_accuracy) EXPECT_NEAR(error, 0.02, 0.001);
  for (const double error : inner->signed_accuracy) EXPECT_NEAR(error, -0.02, 0.001);
  for (const double distance : inner->completeness_distances) EXPECT_NEAR(distance, 0.02, 0.001);
}

TEST(CompareMeshes, TheSameMeshIsAtDistanceZero) {
  const TriangleMesh mesh = sphere(50.0, 30);
  const auto comparison = value_of(compare_meshes(mesh, mesh, {.samples = 5000}));
  EXPECT_LT(comparison.accuracy.all.distance.max, 1e-12);
  EXPECT_LT(comparison.completeness.all.normals_deg.max, 1e-3);
  for (const double f : comparison.f_score) EXPECT_EQ(f, 1.0);
}

TEST(CompareMeshes, DoesNotDependOnTheFrame) {
  const RigidMotion motion =
      motion_from_tangent((RigidTangent() << 0.3, -1, 2, 5, 6, -7).finished());
  TriangleMesh a = sphere(1.02, 30), b = sphere(1.0, 30);
  const auto before = compare_meshes(a, b, {.samples = 5000});
  for (auto* mesh : {&a, &b})
    for (auto& vertex : mesh->vertices) vertex = motion * vertex;
  const auto after = compare_meshes(a, b, {.samples = 5000});
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(before->accuracy.all.distance.rms, after->accuracy.all.distance.rms, 1e-12);
  EXPECT_NEAR(before->completeness.all.distance.p95, after->completeness.all.distance.p95, 1e-12);
}

TEST(CompareMeshes, AShiftedPlaneIsOffByTheShift) {
  const auto comparison =
      value_of(compare_meshes(square(1.0, 0.25), square(1.0, 0.0), {.samples = 1000}));
  expect_all_equal(comparison.accuracy.all.distance, 0.25, 1e-15);
  EXPECT_EQ(comparison.accuracy.all.normals_deg.max, 0.0);
}

TEST(CompareMeshes, CompletenessSeesWhatIsMissing) {
  // The result covers a quarter of the truth: distances to it beyond are those to a square corner.
  const auto comparison = value_of(
      compare_meshes(square(1.0, 0.0), square(2.0, 0.0), {.samples = 40000, .thresholds = {1e-9}}));
  EXPECT_LT(comparison.accuracy.all.distance.max, 1e-14);
  EXPECT_NEAR(comparison.completeness.all.within[0], 0.25, 0.01);
  EXPECT_NEAR(comparison.f_score[0], 2.0 * 0.25 / 1.25, 0.01);
  EXPECT_NEAR(comparison.completeness.all.distance.max, std::sqrt(2.0), 0.02);
  // Two strips of mean distance 1/2 and a corner square whose mean distance to its corner is
  // (sqrt 2 + asinh 1) / 3.
  const double corner = (std::sqrt(2.0) + std::asinh(1.0)) / 3.0;
  EXPECT_NEAR(comparison.completeness.all.distance.mean, 0.25 * (0.5 + 0.5 + corner), 0.005);
}

TEST(CompareMeshes, SplitsMeasuredFromFilled) {
  // The lower half is filled, and wrong by more.
  TriangleMesh truth = sphere(1.0, 60), result = truth;
  for (auto& vertex : result.vertices) {
    const bool filled = vertex.z() < 0.0;
    result.filled.push_back(filled);
    vertex *= filled ? 1.05 : 1.01;
  }
  const auto comparison = value_of(compare_meshes(result, truth, {.samples = 20000}));
  ASSERT_TRUE(comparison.accuracy.measured && comparison.accuracy.filled);
  EXPECT_NEAR(comparison.accuracy.measured->distance.median, 0.01, 1e-5);
  EXPECT_NEAR(comparison.accuracy.filled->distance.median, 0.05, 5e-5);
  EXPECT_NEAR(comparison.completeness.measured->distance.median, 0.01, 1e-5);
  EXPECT_NEAR(comparison.completeness.filled->distance.median, 0.05, 5e-5);
  EXPECT_NEAR(comparison.filled_fraction, 0.52, 0.02);
  EXPECT_EQ(
      comparison.accuracy.measured->distance.count + comparison.accuracy.filled->distance.count,
      20000u);
}

TEST(CompareMeshes, ThresholdsFollowTheSpacing) {
  const auto given =
      value_of(compare_meshes(sphere(1, 5), sphere(1, 5), {.samples = 10, .spacing = 0.4}));
  EXPECT_EQ(given.thresholds, (std::vector<double>{0.1, 0.2, 0.4, 0.8}));
  const auto derived = value_of(compare_meshes(sphere(1, 5), square(3.0, 0), {.samples = 10}));
  EXPECT_NEAR(derived.thresholds[2], 3.0, 1.3);
}

TEST(CompareMeshes, DoesNotDependOnTheThreadCount) {
  const TriangleMesh a = sphere(1.03, 20), b = sphere(1.0, 23);
  const auto one = compare_meshes(a, b, {.samples = 5000}, {.threads = 1});
  const auto three = compare_meshes(a, b, {.samples = 5000}, {.threads = 3});
  ASSERT_TRUE(one && three);
  EXPECT_EQ(one->accuracy.all.distance.rms, three->accuracy.all.distance.rms);
  EXPECT_EQ(one->completeness.all.normals_deg.mean, three->completeness.all.normals_deg.mean);
}

TEST(CompareMeshes, NamesTheMeshThatCannotBeCompared) {
  EXPECT_THAT(compare_meshes(sphere(1, 2), {}), HasError(ErrorKind::kBadInput, "true mesh"));
  TriangleMesh broken = sphere(1, 2);
  broken.vertices[7].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(compare_meshes(broken, sphere(1, 2)), HasError("vertex 7 of the result"));
}

// Each sphere says itself what was filled: A its lower half, B all beyond a plane.
TEST(MutualDistances, AreTheGapOfTwoSpheresBothWays) {
  const double gap = 0.02;
  TriangleMesh a = sphere(1.0), b = sphere(1.0 + gap);
  for (const auto& vertex : a.vertices) a.filled.push_back(vertex.z() < 0.0);
  for (const auto& vertex : b.vertices) b.filled.push_back(vertex.x() > 0.5 * (1.0 + gap));
  const auto distances = mutual_distances(a, b, {.samples = 20000, .thresholds = {0.019, 0.021}});
  ASSERT_TRUE(distances);
  for (const DistanceReport* way : {&distances->a_to_b, &distances->b_to_a}) {
    expect_all_equal(way->all.distance, gap, 2e-4 * gap);
    EXPECT_EQ(way->all.distance.count, 20000u);
    EXPECT_LT(way->all.normals_deg.max, 0.05);
    EXPECT_EQ(way->all.within, (std::vector<double>{0.0, 1.0}));
    ASSERT_TRUE(way->measured && way->filled);
    expect_all_equal(way->measured->distance, gap, 2e-4 * gap);
    EXPECT_EQ(way->measured->distance.count + way->filled->distance.count, 20000u);
  }
  EXPECT_NEAR(static_cast<double>(distances->a_to_b.filled->distance.count), 0.5 * 20000, 200);
  // A cap of height h has the share h / 2r of a sphere.
  EXPECT_NEAR(static_cast<double>(distances->b_to_a.filled->distance.count), 0.25 * 20000, 200);
}

TEST(MutualDistances, SeeAPartThatOnlyOneHas) {
  const auto distances = mutual_distances(square(1.0, 0.0), square(2.0, 0.0), {.samples = 40000});
  ASSERT_TRUE(distances);
  EXPECT_LT(distances->a_to_b.all.distance.max, 1e-14);
  EXPECT_NEAR(distances->b_to_a.all.distance.max, std::sqrt(2.0), 0.02);
  const double corner = (std::sqrt(2.0) + std::asinh(1.0)) / 3.0;
  EXPECT_NEAR(distances->b_to_a.all.distance.mean, 0.25 * (0.5 + 0.5 + corner), 0.005);
  EXPECT_FALSE(distances->a_to_b.measured);
  EXPECT_EQ(distances->thresholds, (std::vector<double>{0.5, 1.0, 2.0, 4.0}));
}

TEST(MutualDistances, SwapWithTheMeshes) {
  const TriangleMesh a = sphere(1.03, 20), b = sphere(1.0, 23);
  const auto one = mutual_distances(a, b, {.samples = 5000}, {.threads = 1});
  const auto other = mutual_distances(b, a, {.samples = 5000}, {.threads = 3});
  ASSERT_TRUE(one && other);
  EXPECT_EQ(one->a_to_b.all.distance.rms, other->b_to_a.all.distance.rms);
  EXPECT_EQ(one->b_to_a.all.normals_deg.mean, other->a_to_b.all.normals_deg.mean);
  EXPECT_EQ(one->thresholds, other->thresholds);
}

TEST(MutualDistances, DoNotDependOnTheThreadCount) {
  const TriangleMesh a = sphere(1.03, 20), b = sphere(1.0, 23);
  const auto one = mutual_distances(a, b, {.samples = 5000}, {.threads = 1});
  const auto three = mutual_distances(a, b, {.samples = 5000}, {.threads = 3});
  ASSERT_TRUE(one && three);
  EXPECT_EQ(one->a_to_b.all.distance.mean, three->a_to_b.all.distance.mean);
  EXPECT_EQ(one->b_to_a.all.distance.p95, three->b_to_a.all.distance.p95);
}

TEST(MutualDistances, NameTheMeshThatCannotBeCompared) {
  const auto empty = mutual_distances(sphere(1, 2), {});
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().kind, ErrorKind::kBadInput);
  EXPECT_NE(empty.error().message.find("second mesh"), std::string::npos);
}

TEST(SignedDistances, HaveTheSignOfTheSideAlsoAtEdgesAndCorners) {
  const TriangleMesh cube = box();
  TriangleMesh points;
  std::vector<double> expected;
  for (double x = -0.55; x < 1.6; x += 0.1) {
    for (double y = -0.55; y < 1.6; y += 0.1) {
      for (double z = -0.55; z < 1.6; z += 0.1) {
        const Eigen::Vector3d p(x, y, z), half = Eigen::Vector3d::Constant(0.5);
        const Eigen::Vector3d q = (p - half).cwiseAbs() - half;
        points.vertices.push_back(p);
        expected.push_back(q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0));
      }
    }
  }
  const auto distances = signed_distances(points, cube);
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(distances[i], expected[i], 1e-12) << points.vertices[i].transpose();
}

TEST(SignedDistances, AreTheRadialErrorOfASphere) {
  TriangleMesh wavy = sphere(1.0, 40);
  std::vector<double> errors;
  for (auto& vertex : wavy.vertices) {
    errors.push_back(0.01 * std::sin(5.0 * vertex.x()));
    vertex *= 1.0 + errors.back();
  }
  const auto distances = signed_distances(wavy, sphere(1.0, 80));
  for (std::size_t i = 0; i < errors.size(); ++i) EXPECT_NEAR(distances[i], errors[i], 1e-4);
}

}  // namespace
}  // namespace relief::evaluation
