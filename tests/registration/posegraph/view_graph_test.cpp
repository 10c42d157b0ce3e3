#include "registration/posegraph/view_graph.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

TEST(ViewGraph, LinksNeighboursOfARingAndNotOppositeViews) {
  const auto views = testing::ring_of_views({.views = 8});
  std::vector<ViewSurface> surfaces;
  for (const auto& view : views) surfaces.emplace_back(view);
  ViewGraphOptions options;
  options.max_distance = 4.0 * surfaces[0].spacing();
  const auto pairs = find_overlapping_pairs(surfaces, testing::poses_of(views), options);
  const auto linked = [&](std::size_t a, std::size_t b) {
    for (const auto& pair : pairs)
      if (pair.a == a && pair.b == b) return true;
    return false;
  };
  for (std::size_t i = 0; i + 1 < 8; ++i) EXPECT_TRUE(linked(i, i + 1));
  EXPECT_TRUE(linked(0, 7));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_FALSE(linked(i, i + 4));
  EXPECT_EQ(connected_groups(8, pairs), std::vector<std::size_t>(8, 0));
}

TEST(ViewGraph, MeetingPairsAreThoseOfBruteForce) {
  const auto views = testing::ring_of_views({.views = 12, .pixels = 40});
  std::vector<ViewSurface> surfaces;
  for (const auto& view : views) surfaces.emplace_back(view);
  std::mt19937 generator(2);
  std::normal_distribution<double> normal(0.0, 3.0 * surfaces[0].radius());
  auto poses = testing::poses_of(views);
  for (RigidMotion& pose : poses)
    pose.pretranslate(Eigen::Vector3d(normal(generator), normal(generator), normal(generator)));
  for (const double margin : {0.0, surfaces[0].radius()}) {
    std::vector<std::pair<std::size_t, std::size_t>> found, expected;
    for (const auto& pair : find_meeting_pairs(surfaces, poses, margin))
      found.emplace_back(pair.a, pair.b);
    for (std::size_t a = 0; a < 12; ++a)
      for (std::size_t b = a + 1; b < 12; ++b)
        if ((poses[a] * surfaces[a].centre() - poses[b] * surfaces[b].centre()).norm() <=
            surfaces[a].radius() + surfaces[b].radius() + margin)
          expected.emplace_back(a, b);
    EXPECT_FALSE(expected.empty());
    EXPECT_EQ(found, expected);
  }
}

TEST(ViewGraph, KeepsTheLargestOverlapsOfEachViewAndItsGroupsTogether) {
  // Two groups of three that share little.
  const std::vector<ViewPair> pairs = {{0, 1, 0.9}, {0, 2, 0.5}, {1, 2, 0.8}, {1, 4, 0.1},
                                       {2, 3, 0.2}, {3, 4, 0.9}, {3, 5, 0.4}, {4, 5, 0.7}};
  const auto kept = largest_overlaps(6, pairs, 1);
  std::vector<std::pair<std::size_t, std::size_t>> names;
  for (const auto& pair : kept) names.emplace_back(pair.a, pair.b);
  EXPECT_EQ(names, (std::vector<std::pair<std::size_t, std::size_t>>{
                       {0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}}));
  EXPECT_EQ(largest_overlaps(6, pairs, 10).size(), pairs.size());
}

TEST(ViewGraph, GroupsFollowChainsInAnyOrder) {
  EXPECT_EQ(connected_groups(6, {{2, 5, 1}, {0, 1, 1}, {3, 5, 1}}),
            (std::vector<std::size_t>{0, 0, 2, 2, 4, 2}));
  EXPECT_EQ(connected_groups(4, {{2, 3, 1}, {1, 2, 1}, {0, 3, 1}}),
            (std::vector<std::size_t>(4, 0)));
}

}  // namespace
}  // namespace relief::registration
