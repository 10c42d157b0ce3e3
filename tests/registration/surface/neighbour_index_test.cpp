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

TEST(NeighbourIndex, HoldsASinglePoint) {
  const NeighbourIndex index(Eigen::Matrix3Xd::Zero(3, 1));
  EXPECT_EQ(index.nearest(Eigen::Matrix3Xd::Ones(3, 2)), (std::vector<int>{0, 0}));
}

}  // namespace
}  // namespace relief::registration
