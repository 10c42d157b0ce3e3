#include "registration/posegraph/loops/view_cycles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace relief::registration {
namespace {

using Cycle = std::vector<std::size_t>;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

TEST(SmallestCycles, ATreeHasNone) {
  EXPECT_THAT(smallest_cycles(5, {{0, 1, 0.5}, {1, 2, 0.5}, {1, 3, 0.5}}), IsEmpty());
  EXPECT_THAT(smallest_cycles(2, {}), IsEmpty());
}

TEST(SmallestCycles, ARingIsOne) {
  EXPECT_THAT(smallest_cycles(5, {{0, 2, 0.3}, {0, 4, 0.5}, {1, 2, 0.2}, {1, 3, 0.4}, {3, 4, 0.6}}),
              ElementsAre(Cycle{0, 2, 1, 3, 4}));
}

// A square with one diagonal has two triangles, and three pairs outside its tree would be four.
TEST(SmallestCycles, TakesTheShortestWay) {
  EXPECT_THAT(smallest_cycles(4, {{0, 1, 0.5}, {0, 2, 0.1}, {0, 3, 0.5}, {1, 2, 0.5}, {2, 3, 0.4}}),
              UnorderedElementsAre(Cycle{0, 1, 2}, Cycle{0, 2, 3}));
}

// Any two views have a way through either of the others; those through view 3 are wider.
TEST(SmallestCycles, OfAsShortOnesTakesTheWidest) {
  EXPECT_THAT(
      smallest_cycles(
          4, {{0, 1, 0.2}, {0, 2, 0.2}, {0, 3, 0.9}, {1, 2, 0.2}, {1, 3, 0.8}, {2, 3, 0.7}}),
      UnorderedElementsAre(Cycle{0, 1, 3}, Cycle{0, 2, 3}, Cycle{1, 2, 3}));
}

TEST(SmallestCycles, ListsEachOnce) {
  std::vector<ViewPair> all;
  for (std::size_t a = 0; a < 5; ++a)
    for (std::size_t b = a + 1; b < 5; ++b)
      all.push_back({a, b, 0.5 + 0.01 * static_cast<double>(a + b)});
  const auto cycles = smallest_cycles(5, all);
  EXPECT_EQ(cycles.size(), 6u);  // Ten pairs, four of them in the tree.
  for (const Cycle& cycle : cycles) EXPECT_EQ(cycle.size(), 3u);
}

}  // namespace
}  // namespace relief::registration
