#include "registration/posegraph/joint/joint_solver.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "registration/posegraph/joint/joint_refinement.h"
#include "relief/scan/context.h"
#include "scan/base/memory/memory_limit.h"
#include "tests/registration/bumpy_object.h"
#include "tests/support/memory_limits.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief::registration {
namespace {

using testing::perturbed;
using testing::poses_of;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Neighbours on a ring, slightly off their true poses.
std::vector<RangeView> two_views() {
  const auto ring = testing::ring_of_views();
  return perturbed({ring[0], ring[1]}, Eigen::Vector3d::Zero(), 0.01, 0.1);
}

std::vector<ViewSurface> surfaces_of(const std::vector<RangeView>& views) {
  std::vector<ViewSurface> surfaces;
  for (const RangeView& view : views) surfaces.emplace_back(view);
  return surfaces;
}

bool same_bytes(const std::vector<RigidMotion>& a, const std::vector<RigidMotion>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::memcmp(a[i].data(), b[i].data(), 16 * sizeof(double)) != 0) return false;
  return a.size() == b.size();
}

// The samples that only the last steps of the refinement use.
void trust_edges_infinitely(const ViewSurface& surface, RangeView& view) {
  view.confidence = Grid<float>(view.width(), view.height(), 1.0f);
  for (const std::uint32_t i : surface.edge_samples()) view.confidence[i] = kInfinity;
}

DirectedMatches matches_of(const std::vector<ViewSurface>& surfaces,
                           const std::vector<RangeView>& views) {
  CorrespondenceOptions search;
  search.count = 200;
  search.max_distance = 5.0 * surfaces[0].spacing();
  const RigidMotion motion = views[1].world_from_view.inverse() * views[0].world_from_view;
  return {0, 1, find_correspondences(surfaces[0], surfaces[1], motion, search), {}};
}

TEST(JointSolver, SaysWhetherItsSolutionIsOfUse) {
  const auto views = two_views();
  const auto surfaces = surfaces_of(views);
  std::vector<DirectedMatches> matches{matches_of(surfaces, views)};
  const auto given = poses_of(views);
  auto poses = given;
  const auto match = [&](std::size_t i) { return matches[i]; };
  const auto summary = solve_poses(surfaces, 1, match, {true, false}, {}, poses);
  EXPECT_EQ(summary.termination, SolverTermination::kIterationLimit);
  EXPECT_EQ(summary.stage, SolverStage::kJoint);
  EXPECT_EQ(summary.iterations, JointSolverOptions().max_iterations);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_FALSE(summary.message.empty());
  EXPECT_FALSE(same_bytes(poses, given));

  poses = given;
  matches[0].found.items[7].weight = kInfinity;
  EXPECT_EQ(solve_poses(surfaces, 1, match, {true, false}, {}, poses).termination,
            SolverTermination::kFailed);
  EXPECT_TRUE(same_bytes(poses, given));
}

// Beyond what lies in files, at most, while `pairs` directed pairs are matched [bytes].
std::size_t most_memory_for(std::size_t pairs) {
  const auto views = two_views();
  const auto surfaces = surfaces_of(views);
  const DirectedMatches matches = matches_of(surfaces, views);
  const testing::TemporaryFolder folder;
  const Context context{
      .threads = 1, .memory = 100 * testing::kMebibyte, .temporary_folder = folder.path()};
  std::size_t most = 0;
  const auto match = [&](std::size_t i) {
    if (i % 100 == 0) most = std::max(most, resident_beyond_files());
    return matches;
  };
  auto poses = poses_of(views);
  EXPECT_TRUE(run_until_stopped(context, [&] {
    EXPECT_NE(solve_poses(surfaces, pairs, match, {true, false}, {}, poses).termination,
              SolverTermination::kFailed);
  }));
  return most;
}

TEST(JointSolver, ManyPairsNeedNoMoreMemoryThanFew) {
  EXPECT_LT(most_memory_for(4000), most_memory_for(400) + 24 * testing::kMebibyte);
}

TEST(JointRefinement, SaysThatItsSolverFailed) {
  auto views = two_views();
  for (RangeView& view : views)
    view.confidence = Grid<float>(view.width(), view.height(), kInfinity);
  const auto refined = value_of(refine_jointly(surfaces_of(views), poses_of(views),
                                               std::vector<ViewRole>(2, ViewRole::kFree)));
  EXPECT_EQ(refined.termination, RefinementTermination::kSolverFailed);
  EXPECT_EQ(to_string(refined.termination), "solver failed");
  ASSERT_FALSE(refined.solves.empty());
  EXPECT_EQ(to_string(refined.solves.back().termination), "failed");
  EXPECT_TRUE(same_bytes(refined.world_from_view, poses_of(views)));
}

TEST(JointRefinement, SaysThatItsLastStepsFailed) {
  auto views = two_views();
  const auto surfaces = surfaces_of(views);
  for (std::size_t i = 0; i < 2; ++i) trust_edges_infinitely(surfaces[i], views[i]);
  const auto refined = value_of(refine_jointly(surfaces_of(views), poses_of(views),
                                               std::vector<ViewRole>(2, ViewRole::kFree)));
  EXPECT_EQ(refined.termination, RefinementTermination::kSolverFailed);
  for (const RigidMotion& pose : refined.world_from_view) EXPECT_TRUE(pose.matrix().allFinite());
}

}  // namespace
}  // namespace relief::registration
