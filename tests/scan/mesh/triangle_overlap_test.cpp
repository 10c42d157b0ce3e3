#include "scan/mesh/triangle_overlap.h"

#include <algorithm>
#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace relief {
namespace {

using Polygon = std::vector<Eigen::Vector3d>;

constexpr double kTolerance = 1e-9;

// The part of a polygon where normal . x >= offset (Sutherland and Hodgman 1974).
Polygon clipped(const Polygon& polygon, const Eigen::Vector3d& normal, double offset) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d &here = polygon[i], &next = polygon[(i + 1) % polygon.size()];
    const double h = normal.dot(here) - offset, n = normal.dot(next) - offset;
    if (h >= -kTolerance) kept.push_back(here);
    if ((h > kTolerance && n < -kTolerance) || (h < -kTolerance && n > kTolerance))
      kept.push_back(here + h / (h - n) * (next - here));
  }
  return kept;
}

Polygon common_part(const Triangle& a, const Triangle& b) {
  const Eigen::Vector3d normal = (a[1] - a[0]).cross(a[2] - a[0]);
  Polygon part(b.begin(), b.end());
  part = clipped(part, normal, normal.dot(a[0]));
  part = clipped(part, -normal, -normal.dot(a[0]));
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d inwards = normal.cross(a[(k + 1) % 3] - a[k]);
    part = clipped(part, inwards, inwards.dot(a[k]));
  }
  return part;
}

bool on_segment(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& p) {
  return (p - a).norm() + (p - b).norm() < (b - a).norm() + kTolerance;
}

// By clipping, for small integer coordinates, whose plane distances are far above the tolerance.
bool overlap_by_clipping(const Triangle& a, const Triangle& b) {
  Polygon common;
  for (const auto& corner : a)
    if (std::find(b.begin(), b.end(), corner) != b.end()) common.push_back(corner);
  for (const auto& p : common_part(a, b)) {
    const bool shared = (common.size() == 1 && (p - common[0]).norm() < kTolerance) ||
                        (common.size() == 2 && on_segment(common[0], common[1], p));
    if (!shared) return true;
  }
  return false;
}

TEST(Overlap, AgreesWithClippingOnALattice) {
  std::mt19937 generator(1);
  std::array<std::array<int, 2>, 4> seen{};
  for (const int size : {2, 3, 5, 9}) {
    std::uniform_int_distribution<int> coordinate(0, size - 1);
    const auto random_triangle = [&] {
      Triangle t;
      do {
        for (auto& corner : t)
          corner = {double(coordinate(generator)), double(coordinate(generator)),
                    double(coordinate(generator))};
      } while (collinear(t));
      return t;
    };
    for (int round = 0; round < 20000; ++round) {
      const Triangle a = random_triangle();
      Triangle b = random_triangle();
      const std::size_t shared = round % 3;
      for (std::size_t k = 0; k < shared; ++k) b[k] = a[(k + 1) % 3];
      if (collinear(b)) continue;
      const bool expected = overlap_by_clipping(a, b);
      ++seen[shared][expected];
      ASSERT_EQ(overlap(a, b), expected)
          << a[0].transpose() << ", " << a[1].transpose() << ", " << a[2].transpose() << " and "
          << b[0].transpose() << ", " << b[1].transpose() << ", " << b[2].transpose();
      ASSERT_EQ(overlap(b, a), expected);
      ASSERT_EQ(overlap({a[2], a[0], a[1]}, {b[1], b[0], b[2]}), expected);
    }
  }
  for (int shared = 0; shared < 3; ++shared)
    for (const int count : seen[shared]) EXPECT_GT(count, 300) << shared << " shared corners";
}

const Triangle kFlat{Eigen::Vector3d(0, 0, 0), {1, 0, 0}, {0, 1, 0}};

TEST(Overlap, NeighboursOfASurfaceDoNot) {
  EXPECT_FALSE(overlap(kFlat, {Eigen::Vector3d(1, 0, 0), {1, 1, 0}, {0, 1, 0}}));  // flat, one edge
  EXPECT_FALSE(
      overlap(kFlat, {Eigen::Vector3d(1, 0, 0), {0, 0, 0}, {0, 1, 1e-300}}));        // sharp fold
  EXPECT_FALSE(overlap(kFlat, {Eigen::Vector3d(0, 0, 0), {-1, 0, 0}, {0, -1, 0}}));  // one corner
  EXPECT_FALSE(overlap(kFlat, {Eigen::Vector3d(2, 0, 0), {3, 0, 0}, {2, 1, 0}}));    // apart
}

TEST(Overlap, FoldsAndCopiesDo) {
  EXPECT_TRUE(overlap(kFlat, kFlat));
  EXPECT_TRUE(overlap(kFlat, {kFlat[1], kFlat[0], kFlat[2]}));
  EXPECT_TRUE(overlap(kFlat, {Eigen::Vector3d(1, 0, 0), {0, 0, 0}, {0.5, 0.5, 0}}));
  EXPECT_TRUE(
      overlap(kFlat, {Eigen::Vector3d(0, 0, 0), {2, 1, 0}, {1, 2, 0}}));  // one corner, flat
}

TEST(Overlap, TouchingDoes) {
  EXPECT_TRUE(overlap(kFlat, {Eigen::Vector3d(0.25, 0.25, 0), {0, 0, 1}, {1, 0, 1}}));  // inside
  EXPECT_TRUE(overlap(kFlat, {Eigen::Vector3d(0.5, 0, 0), {0, -1, 1}, {1, -1, 1}}));  // on an edge
  EXPECT_TRUE(overlap(kFlat, {Eigen::Vector3d(1, 0, 0), {-1, 0, 0}, {0, 0, 1}}));     // T-junction
}

TEST(Collinear, IsExact) {
  EXPECT_TRUE(collinear({Eigen::Vector3d(0, 0, 0), {1, 2, 3}, {2, 4, 6}}));
  EXPECT_TRUE(collinear({Eigen::Vector3d(1, 1, 1), {1, 1, 1}, {2, 4, 6}}));
  EXPECT_FALSE(collinear({Eigen::Vector3d(0, 0, 0), {1, 2, 3}, {2, 4, std::nextafter(6.0, 7.0)}}));
}

}  // namespace
}  // namespace relief
