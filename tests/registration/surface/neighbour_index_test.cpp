#include "registration/surface/neighbour_index.h"

#include <gtest/gtest.h>

namespace relief::registration {
namespace {

int brute_force(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& query) {
  Eigen::Index best = 0;
  (points.colwise() - query).colwise().squaredNorm().minCoeff(&best);
  return static_cast<int>(best);
}

TEST(NeighbourIndex, AgreesWithBruteForce) {
  std::srand(3);
  const Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Random(3, 2000);
  const Eigen::Matrix3Xd queries = 1.2 * Eigen::Matrix3Xd::Random(3, 300);
  const NeighbourIndex index(points);
  const auto nearest = index.nearest(queries);
  for (int i = 0; i < 300; ++i)
    EXPECT_EQ(nearest[static_cast<std::size_t>(i)], brute_force(points, queries.col(i)));
}

TEST(NeighbourIndex, IsAsGoodAMillionSpacingsFromTheOrigin) {
  std::srand(4);
  const Eigen::Vector3d far(1e5, -2e5, 3e5);
  const Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Random(3, 500).colwise() + far;
  const Eigen::Matrix3Xd queries = Eigen::Matrix3Xd::Random(3, 100).colwise() + far;
  const auto nearest = NeighbourIndex(points).nearest(queries);
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(nearest[static_cast<std::size_t>(i)], brute_force(points, queries.col(i)));
}

TEST(NeighbourIndex, FindsTheNeighboursWithinARadius) {
  std::srand(5);
  const Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Random(3, 800);
  const auto neighbours = NeighbourIndex(points).neighbours_within(0.3);
  ASSERT_EQ(neighbours.size(), 800u);
  for (int i = 0; i < 800; ++i) {
    std::vector<int> expected;
    for (int j = 0; j < 800; ++j)
      if (j != i && (points.col(j) - points.col(i)).norm() < 0.3) expected.push_back(j);
    EXPECT_EQ(neighbours[static_cast<std::size_t>(i)], expected);
  }
}

TEST(NeighbourIndex, HoldsASinglePoint) {
  const NeighbourIndex index(Eigen::Matrix3Xd::Zero(3, 1));
  EXPECT_EQ(index.nearest(Eigen::Matrix3Xd::Ones(3, 2)), (std::vector<int>{0, 0}));
  EXPECT_EQ(index.neighbours_within(1.0), std::vector<std::vector<int>>(1));
}

}  // namespace
}  // namespace relief::registration
