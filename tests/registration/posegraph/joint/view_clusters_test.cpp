#include "registration/posegraph/joint/view_clusters.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

using ::testing::ElementsAre;
using Views = std::vector<std::size_t>;

// Samples whose normals are noise, but for a share of relief in them.
PairConstraint pair_of(std::size_t a, std::size_t b, double relief, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&] {
    return Eigen::Vector3d(normal(random), normal(random), normal(random));
  };
  PairConstraint pair{a, b, SharedConstraintSum(Eigen::Vector3d::Zero(), 1.0)};
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d both = relief * vector();
    pair.shared.add({50.0 * vector(), (both + (1 - relief) * vector()).normalized()},
                    (both + (1 - relief) * vector()).normalized());
  }
  return pair;
}

class ViewClusters : public ::testing::Test {
 protected:
  static std::vector<Views> of(const std::vector<PairConstraint>& pairs, std::size_t views) {
    const auto ring = testing::ring_of_views({.views = static_cast<int>(views), .pixels = 40});
    std::vector<ViewSurface> surfaces;
    for (const auto& view : ring) surfaces.emplace_back(view);
    std::vector<Views> found;
    for (const auto& cluster : cluster_views(surfaces, testing::poses_of(ring), pairs))
      found.push_back(cluster.views);
    return found;
  }
};

TEST_F(ViewClusters, JoinWhatHoldsEachOtherMostFirst) {
  // 0 - 2 and 1 - 3 hold each other; 4 holds little to 3; 5 is linked to nothing.
  const std::vector<PairConstraint> pairs = {pair_of(0, 2, 0.9, 1), pair_of(0, 1, 0.0, 2),
                                             pair_of(1, 3, 0.8, 3), pair_of(3, 4, 0.6, 4),
                                             pair_of(2, 3, 0.0, 5)};
  EXPECT_THAT(of(pairs, 6), ElementsAre(Views{0}, Views{1}, Views{2}, Views{3}, Views{4},
                                        Views{0, 2}, Views{1, 3}, Views{1, 3, 4}));
}

TEST_F(ViewClusters, SumUpWhatHoldsThemToOthers) {
  // One pair alone would hold 0 to 1; with the noise of another one it does less than 1 - 2 do.
  const std::vector<PairConstraint> pairs = {pair_of(0, 1, 0.7, 1), pair_of(0, 1, 0.0, 2),
                                             pair_of(1, 2, 0.6, 3)};
  EXPECT_THAT(of(pairs, 3), ElementsAre(Views{0}, Views{1}, Views{2}, Views{1, 2}));
}

TEST_F(ViewClusters, HoldEachOtherOrShareNoView) {
  std::mt19937 random(5);
  std::vector<PairConstraint> pairs;
  for (std::uint32_t k = 0; k < 40; ++k) {
    const std::size_t a = random() % 12, b = random() % 12;
    if (a != b) pairs.push_back(pair_of(std::min(a, b), std::max(a, b), 0.1 * (k % 10), k));
  }
  const auto clusters = of(pairs, 12);
  EXPECT_GT(clusters.size(), 15u);
  for (const Views& a : clusters)
    for (const Views& b : clusters) {
      Views common;
      std::ranges::set_intersection(a, b, std::back_inserter(common));
      EXPECT_TRUE(common.empty() || common == a || common == b);
    }
}

}  // namespace
}  // namespace relief::registration
