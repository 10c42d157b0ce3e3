#include "scan/mesh/exact_predicates.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace relief {
namespace {

__extension__ using Integer = __int128;
using IntegerPoint = std::array<std::int64_t, 3>;

Eigen::Vector3d as_doubles(const IntegerPoint& p) {
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

int sign(Integer value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

// The determinant of (b - a, c - a, p - a) in integers, without rounding below 2^40.
int true_side(const IntegerPoint& a, const IntegerPoint& b, const IntegerPoint& c,
              const IntegerPoint& p) {
  const auto u = [&](int k) { return Integer(b[k] - a[k]); };
  const auto v = [&](int k) { return Integer(c[k] - a[k]); };
  const auto w = [&](int k) { return Integer(p[k] - a[k]); };
  return sign(u(0) * (v(1) * w(2) - v(2) * w(1)) + u(1) * (v(2) * w(0) - v(0) * w(2)) +
              u(2) * (v(0) * w(1) - v(1) * w(0)));
}

TEST(SideOfPlane, IsPositiveWhereTheNormalPoints) {
  const Eigen::Vector3d a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  EXPECT_EQ(side_of_plane(a, b, c, {0.2, 0.7, 1e-300}), 1);
  EXPECT_EQ(side_of_plane(a, b, c, {0.2, 0.7, -1e-300}), -1);
  EXPECT_EQ(side_of_plane(a, b, c, {5, -9, 0}), 0);
  EXPECT_EQ(side_of_plane(a, b, 3.0 * b, {5, -9, 7}), 0);
}

int plain_side(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
               const Eigen::Vector3d& p) {
  const double determinant = (b - a).cross(c - a).dot(p - a);
  return determinant > 0.0 ? 1 : determinant < 0.0 ? -1 : 0;
}

// Points of up to 53 bits in a common plane or one unit off it, where plain arithmetic is often
// wrong.
TEST(SideOfPlane, AgreesWithIntegersNearThePlane) {
  std::mt19937_64 generator(1);
  std::uniform_int_distribution<std::int64_t> wide(-(1ll << 18), 1ll << 18), near(-1, 1);
  std::uniform_int_distribution<std::int64_t> factor(-(1ll << 32), 1ll << 32);
  int zeros = 0, plain_errors = 0;
  for (int round = 0; round < 20000; ++round) {
    // p = a + s (b - a) + t (c - a) plus a step of at most one unit.
    IntegerPoint a, b, c, p;
    const std::int64_t s = factor(generator), t = factor(generator);
    for (int k = 0; k < 3; ++k) {
      a[k] = wide(generator), b[k] = wide(generator), c[k] = wide(generator);
      p[k] = a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]) + near(generator) * (k == round % 3);
    }
    const int expected = true_side(a, b, c, p);
    zeros += expected == 0;
    plain_errors +=
        plain_side(as_doubles(a), as_doubles(b), as_doubles(c), as_doubles(p)) != expected;
    ASSERT_EQ(side_of_plane(as_doubles(a), as_doubles(b), as_doubles(c), as_doubles(p)), expected);
  }
  EXPECT_GT(zeros, 5000);
  EXPECT_GT(plain_errors, 1000);
}

// Coordinates of very different sizes, so that even their differences do not fit into doubles.
TEST(SideOfPlane, KeepsWhatDifferencesLose) {
  const double tiny = 0x1p-80;
  const Eigen::Vector3d a(1, 0, 0), b(0, 1, 0), c(0, 0, 1);
  EXPECT_EQ(side_of_plane(a, b, c, {tiny, 0.5, 0.5}), 1);
  EXPECT_EQ(side_of_plane(a, b, c, {-tiny, 0.5, 0.5}), -1);
  EXPECT_EQ(side_of_plane(a, b, c, {0, 0.5, 0.5}), 0);
}

TEST(SideOfPlane, ChangesSignWithTheOrder) {
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int round = 0; round < 1000; ++round) {
    Eigen::Matrix<double, 3, 4> p;
    for (auto& x : p.reshaped()) x = uniform(generator);
    if (round % 2) p.col(3) = 0.25 * p.col(0) + 0.25 * p.col(1) + 0.5 * p.col(2);  // in the plane
    const int side = side_of_plane(p.col(0), p.col(1), p.col(2), p.col(3));
    EXPECT_EQ(side_of_plane(p.col(1), p.col(2), p.col(0), p.col(3)), side);
    EXPECT_EQ(side_of_plane(p.col(1), p.col(0), p.col(2), p.col(3)), -side);
    EXPECT_EQ(side_of_plane(p.col(0), p.col(1), p.col(3), p.col(2)), -side);
  }
}

// Points 53 bits apart in size around a diagonal: the example of Kettner et al. 2008, in which
// plain arithmetic gives all three answers at random.
TEST(SideOfLine, AgreesWithIntegersNearTheLine) {
  const Eigen::Vector2d a(12, 12), b(24, 24);
  for (int i = 0; i < 64; ++i) {
    for (int j = 0; j < 64; ++j) {
      const Eigen::Vector2d p(0.5 + i * 0x1p-53, 0.5 + j * 0x1p-53);
      EXPECT_EQ(side_of_line(a, b, p), p.y() > p.x() ? 1 : p.y() < p.x() ? -1 : 0);
    }
  }
}

}  // namespace
}  // namespace relief
