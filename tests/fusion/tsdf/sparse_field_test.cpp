#include "fusion/tsdf/sparse_field.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "fusion/tsdf/obstacle_solver.h"
#include "relief/scan/context.h"
#include "tests/fusion/scenes.h"

namespace relief::fusion {
namespace {

using testing::cube_of_blocks;

template <typename Function>
void fill(SparseField& field, const Function& function, bool active_only = false) {
  for (std::size_t b = 0; b < field.block_count(); ++b) {
    if (active_only && !field.active(b)) continue;
    for (int i = 0; i < kBlockNodes; ++i)
      field.values(b)[i] =
          static_cast<float>(function(Node(field.first_node(b) + node_at_offset(i))));
  }
}

TEST(Lattice, KeysOrderAndInvert) {
  for (const Node& node : {Node(0, 0, 0), Node(-5, 7, 1000), Node(-kKeyOffset, kKeyOffset - 1, 3)})
    EXPECT_EQ(node_of(key_of(node)), node);
  EXPECT_LT(key_of({5, 5, -1}), key_of({0, 0, 0}));
  EXPECT_LT(key_of({5, -1, 0}), key_of({0, 0, 0}));
}

TEST(KeySet, HoldsEachKeyOnceInNoMoreMemoryThanNeeded) {
  KeySet set;
  for (NodeKey i = 0; i < 500'000; ++i) {
    set.add(i * i % 1000);
    ASSERT_LT(set.held(), 70'000u);
  }
  const std::vector<NodeKey> keys = set.take();
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end()));
  EXPECT_EQ(std::adjacent_find(keys.begin(), keys.end()), keys.end());
  EXPECT_EQ(keys.size(), 159u) << "squares modulo 1000";
  EXPECT_EQ(keys.capacity(), keys.size());
}

TEST(SparseField, ProlongsLinearFunctionsExactly) {
  const auto linear = [](const Node& n) { return 0.5 * n.x() - 0.25 * n.y() + 2.0 * n.z() - 3.0; };
  SparseField coarse({Eigen::Vector3d::Zero(), 2.0}, cube_of_blocks(3), nullptr, 1e6f);
  fill(coarse, linear);
  SparseField fine({Eigen::Vector3d::Zero(), 1.0}, {key_of({1, 1, 1}), key_of({2, 1, 1})}, &coarse,
                   1e6f);
  fine.prolong(1e6f);
  for (const Node& n : {Node(9, 8, 15), Node(0, 3, 5), Node(24, 13, 1), Node(37, 36, 35)})
    EXPECT_FLOAT_EQ(fine.value(n),
                    static_cast<float>(0.25 * n.x() - 0.125 * n.y() + 1.0 * n.z() - 3.0));
}

TEST(SparseField, GatherReadsTheNeighbours) {
  SparseField field({Eigen::Vector3d::Zero(), 1.0}, {key_of({0, 0, 0})}, nullptr, 0.0f);
  EXPECT_EQ(field.block_count(), 27u);
  const auto function = [](const Node& n) { return n.x() + 100 * n.y() + 10000 * n.z(); };
  fill(field, function);
  SparseField::Padded padded;
  field.gather(static_cast<std::size_t>(field.find({0, 0, 0})), padded);
  for (const Node& n : {Node(-1, -1, -1), Node(8, 0, 3), Node(8, 8, 8), Node(4, -1, 8)})
    EXPECT_EQ(padded[padded_index(n.x(), n.y(), n.z())], static_cast<float>(function(n)));
}

// A sphere known everywhere on a coarse field, but computed on one fine block only.
TEST(SparseField, ClosesItsZeroSet) {
  const auto sphere = [](const Node& n) {
    return (n.cast<double>() - Eigen::Vector3d(16, 16, 16)).norm() - 10.3;
  };
  SparseField coarse({Eigen::Vector3d::Zero(), 2.0}, cube_of_blocks(4), nullptr, 10.0f);
  fill(coarse, sphere);
  SparseField fine({Eigen::Vector3d::Zero(), 1.0}, {key_of({6, 4, 4})}, &coarse, 10.0f);
  fine.prolong(10.0f);
  fine.close_zero_set(10.0f);
  for (std::size_t b = 0; b < fine.block_count(); ++b) {
    for (int i = 0; i < kBlockNodes; ++i) {
      const Node node = fine.first_node(b) + node_at_offset(i);
      for (int axis = 0; axis < 3; ++axis) {
        const Node next = node + Node(Node::Unit(axis));
        if ((fine.value(node) > 0.0f) == (fine.value(next) > 0.0f)) continue;
        for (const Node& end : {node, next})
          EXPECT_TRUE(fine.active(static_cast<std::size_t>(fine.find(block_of(end)))));
      }
    }
  }
}

class ObstacleSolver : public ::testing::Test {
 protected:
  ObstacleSolver()
      : field_({Eigen::Vector3d::Zero(), 1.0}, cube_of_blocks(2), nullptr, 0.0f),
        constraints_(field_.block_count() * kBlockNodes) {
    for (auto& constraint : constraints_) constraint.floor = -1e6f;
    options_.max_sweeps = 1000;
    options_.tolerance = 1e-7;
  }

  SparseField field_;
  std::vector<NodeConstraint> constraints_;
  ObstacleSolverOptions options_;
};

TEST_F(ObstacleSolver, IsExactForHarmonicFunctions) {
  const auto harmonic = [](const Node& n) {
    const Eigen::Vector3d p = n.cast<double>() / 16.0;
    return p.x() * p.x() + p.y() * p.y() - 2.0 * p.z() * p.z() + p.x() * p.z();
  };
  fill(field_, harmonic);
  fill(
      field_, [](const Node&) { return 0.0; }, true);
  EXPECT_EQ(solve_obstacle_problem(field_, constraints_, options_).moving_blocks, 0u);
  for (const Node& n : {Node(8, 8, 8), Node(1, 14, 3), Node(0, 0, 0)})
    EXPECT_NEAR(field_.value(n), harmonic(n), 1e-4);
}

TEST_F(ObstacleSolver, LiesAboveItsFloorAndIsHarmonicWhereItDoesNotTouchIt) {
  fill(field_, [](const Node&) { return 0.0; });
  for (std::size_t b = 0; b < field_.block_count(); ++b)
    for (int i = 0; i < kBlockNodes; ++i)
      if ((field_.first_node(b) + node_at_offset(i)) == Node(8, 8, 8))
        constraints_[b * kBlockNodes + static_cast<std::size_t>(i)].floor = 1.0f;
  solve_obstacle_problem(field_, constraints_, options_);
  EXPECT_EQ(field_.value({8, 8, 8}), 1.0f);
  for (const Node& n : {Node(9, 8, 8), Node(3, 7, 12), Node(15, 0, 7)}) {
    double mean = 0.0;
    for (int axis = 0; axis < 3; ++axis)
      for (const int sign : {-1, 1}) mean += field_.value(n + sign * Node(Node::Unit(axis))) / 6.0;
    EXPECT_NEAR(field_.value(n), mean, 1e-5);
    EXPECT_GT(field_.value(n), 0.0f);
    EXPECT_LT(field_.value(n), 1.0f);
  }
}

// A value that no free node can change by makes no work.
TEST_F(ObstacleSolver, BlocksAtRestAreLeftOut) {
  fill(field_, [](const Node& n) { return 0.125 * n.x(); });
  EXPECT_LE(solve_obstacle_problem(field_, constraints_, options_).sweeps, 2);
  fill(field_, [](const Node&) { return 0.0; });
  EXPECT_EQ(solve_obstacle_problem(field_, constraints_, options_).sweeps, 1);
}

TEST_F(ObstacleSolver, TellsWhereValuesStillMoved) {
  const auto rough = [](const Node& n) { return std::sin(3.0 * n.x() + 5.0 * n.y() + n.z()); };
  fill(field_, rough);
  options_.max_sweeps = 5;
  const ObstacleSolution cut_short = solve_obstacle_problem(field_, constraints_, options_);
  EXPECT_EQ(cut_short.sweeps, 5);
  EXPECT_EQ(cut_short.moving_blocks, 8u);
  options_.max_sweeps = 1000;
  const ObstacleSolution rested = solve_obstacle_problem(field_, constraints_, options_);
  EXPECT_LT(rested.sweeps, 1000);
  EXPECT_EQ(rested.moving_blocks, 0u);
}

TEST_F(ObstacleSolver, ThreadsDoNotChangeAByte) {
  const auto rough = [](const Node& n) { return std::sin(3.0 * n.x() + 5.0 * n.y() + n.z()); };
  SparseField other({Eigen::Vector3d::Zero(), 1.0}, cube_of_blocks(2), nullptr, 0.0f);
  fill(field_, rough);
  fill(other, rough);
  options_.max_sweeps = 20;
  on_threads(1, [&] { solve_obstacle_problem(field_, constraints_, options_); });
  on_threads(4, [&] { solve_obstacle_problem(other, constraints_, options_); });
  for (std::size_t b = 0; b < field_.block_count(); ++b)
    for (int i = 0; i < kBlockNodes; ++i) ASSERT_EQ(field_.values(b)[i], other.values(b)[i]);
}

}  // namespace
}  // namespace relief::fusion
