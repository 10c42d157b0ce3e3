#include "registration/posegraph/sphere_lattice.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace relief::registration {
namespace {

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

Pairs by_brute_force(const std::vector<Sphere>& spheres, double margin) {
  Pairs pairs;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::size_t j = i + 1; j < spheres.size(); ++j)
      if ((spheres[i].centre - spheres[j].centre).norm() <=
          spheres[i].radius + spheres[j].radius + margin)
        pairs.emplace_back(i, j);
  return pairs;
}

std::vector<Sphere> random_spheres(std::size_t count, double room, double decades,
                                   const Eigen::Vector3d& around) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Sphere> spheres(count);
  for (Sphere& sphere : spheres) {
    for (double& x : sphere.centre) x = room * (unit(generator) - 0.5);
    sphere.centre += around;
    sphere.radius = std::pow(10.0, -decades * unit(generator));
  }
  return spheres;
}

TEST(SphereLattice, FindsThePairsOfBruteForce) {
  for (const double decades : {0.0, 0.3, 3.0}) {
    for (const double margin : {0.0, 0.5, 30.0}) {
      const auto spheres = random_spheres(1500, 30.0, decades, {0.0, 0.0, 0.0});
      const Pairs expected = by_brute_force(spheres, margin);
      EXPECT_FALSE(expected.empty());
      EXPECT_EQ(near_spheres(spheres, margin), expected) << decades << ' ' << margin;
    }
  }
}

TEST(SphereLattice, FindsThemFarFromTheOrigin) {
  const auto spheres = random_spheres(1000, 20.0, 1.0, {4e6, -3e6, 1e6});
  EXPECT_EQ(near_spheres(spheres, 0.1), by_brute_force(spheres, 0.1));
}

TEST(SphereLattice, FindsPointsAtOnePlaceAndTouchingSpheres) {
  EXPECT_EQ(near_spheres({{}, {}, {}}, 0.0), (Pairs{{0, 1}, {0, 2}, {1, 2}}));
  EXPECT_EQ(near_spheres({{{0.0, 0.0, 0.0}, 1.0}, {{3.0, 0.0, 0.0}, 2.0}}, 0.0), (Pairs{{0, 1}}));
  EXPECT_TRUE(near_spheres({{{0.0, 0.0, 0.0}, 1.0}, {{3.1, 0.0, 0.0}, 2.0}}, 0.0).empty());
  EXPECT_TRUE(near_spheres({}, 1.0).empty());
}

}  // namespace
}  // namespace relief::registration
