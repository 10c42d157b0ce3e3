#include "scan/base/memory/paged_median.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "scan/base/median.h"

namespace relief {
namespace {

TEST(PagedMedian, IsTheMedianOfSortedValues) {
  std::mt19937 random(7);
  for (const std::size_t count : {1, 2, 3, 10, 1001, 40000}) {
    // Of few different values and of many, of both signs, over many powers of ten.
    for (const int kinds : {3, 1 << 20}) {
      std::vector<float> values(count);
      for (float& value : values) {
        const int k = std::uniform_int_distribution<int>(-kinds, kinds)(random);
        value = static_cast<float>(k) * std::pow(10.0f, static_cast<float>(k % 7));
      }
      EXPECT_EQ(paged_median(values), median(std::vector<float>(values))) << count;
    }
  }
}

TEST(PagedMedian, TakesInfiniteValuesAndNone) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(paged_median({}), 0.0f);
  EXPECT_EQ(paged_median(std::vector{kInfinity, -kInfinity, 2.5f}), 2.5f);
  EXPECT_EQ(paged_median(std::vector{kInfinity, kInfinity, 2.5f}), kInfinity);
}

}  // namespace
}  // namespace relief
