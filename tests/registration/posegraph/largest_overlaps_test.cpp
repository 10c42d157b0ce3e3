#include <algorithm>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "registration/posegraph/view_graph.h"
#include "scan/base/counter_random.h"

namespace relief::registration {
namespace {

// As the last steps of refining poses have it.
constexpr int kPerView = 24;

using Names = std::set<std::pair<std::size_t, std::size_t>>;

// Every two views from `first` to before `last` overlap, by different amounts in (0.1, 1).
std::vector<ViewPair> all_pairs(std::size_t first, std::size_t last, std::uint64_t seed) {
  const CounterRandom random(seed, 0);
  std::vector<ViewPair> pairs;
  for (std::size_t a = first; a < last; ++a)
    for (std::size_t b = a + 1; b < last; ++b)
      pairs.push_back({a, b, 0.1 + 0.9 * random.uniform(pairs.size())});
  return pairs;
}

Names names_of(const std::vector<ViewPair>& pairs) {
  Names names;
  for (const ViewPair& pair : pairs) names.emplace(pair.a, pair.b);
  return names;
}

// How many pairs of a view overlap more than this one.
std::ptrdiff_t rank_at(std::size_t view, const ViewPair& pair, const std::vector<ViewPair>& pairs) {
  return std::count_if(pairs.begin(), pairs.end(), [&](const ViewPair& other) {
    return (other.a == view || other.b == view) && other.overlap > pair.overlap;
  });
}

TEST(LargestOverlaps, AreAllOfViewsWithFewNeighbours) {
  for (const std::size_t views : {std::size_t{2}, std::size_t{20}, std::size_t{25}}) {
    const auto pairs = all_pairs(0, views, 1);
    EXPECT_EQ(names_of(largest_overlaps(views, pairs, kPerView)), names_of(pairs)) << views;
  }
  EXPECT_TRUE(largest_overlaps(3, {}, kPerView).empty());
}

TEST(LargestOverlaps, AreThoseAmongTheLargestOfEitherView) {
  constexpr std::size_t kViews = 60;
  const auto pairs = all_pairs(0, kViews, 2);
  Names expected;
  for (const ViewPair& pair : pairs)
    if (std::min(rank_at(pair.a, pair, pairs), rank_at(pair.b, pair, pairs)) < kPerView)
      expected.emplace(pair.a, pair.b);
  EXPECT_LT(expected.size(), pairs.size());
  EXPECT_EQ(names_of(largest_overlaps(kViews, pairs, kPerView)), expected);
}

TEST(LargestOverlaps, FavourNeitherViewOfAPair) {
  constexpr std::size_t kViews = 40;
  const auto pairs = all_pairs(0, kViews, 3);
  std::vector<ViewPair> mirrored;
  for (const ViewPair& pair : pairs)
    mirrored.push_back({kViews - 1 - pair.b, kViews - 1 - pair.a, pair.overlap});
  std::sort(mirrored.begin(), mirrored.end(), [](const ViewPair& x, const ViewPair& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  Names expected;
  for (const ViewPair& pair : largest_overlaps(kViews, pairs, kPerView))
    expected.emplace(kViews - 1 - pair.b, kViews - 1 - pair.a);
  EXPECT_EQ(names_of(largest_overlaps(kViews, mirrored, kPerView)), expected);
}

TEST(LargestOverlaps, KeepWhatConnectsGroups) {
  // Two groups of 30 views that share one small overlap, of views with many larger ones.
  auto pairs = all_pairs(0, 30, 4);
  const auto others = all_pairs(30, 60, 5);
  pairs.insert(pairs.begin() + 29, {0, 59, 0.05});
  pairs.insert(pairs.end(), others.begin(), others.end());
  const auto kept = largest_overlaps(60, pairs, kPerView);
  EXPECT_LT(kept.size(), pairs.size());
  EXPECT_TRUE(names_of(kept).contains({0, 59}));
  EXPECT_EQ(connected_groups(60, kept), std::vector<std::size_t>(60, 0));
}

TEST(LargestOverlaps, TakeTheFirstOfEqualOnesInOrder) {
  std::vector<ViewPair> pairs = all_pairs(0, 5, 6);
  for (ViewPair& pair : pairs) pair.overlap = 0.5;
  const auto kept = largest_overlaps(5, pairs, 1);
  EXPECT_EQ(names_of(kept), (Names{{0, 1}, {0, 2}, {0, 3}, {0, 4}}));
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end(), [](const ViewPair& x, const ViewPair& y) {
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  }));
}

}  // namespace
}  // namespace relief::registration
