#include "registration/verification/deviating_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace relief::registration {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

// A ring of eight views, each with the next two.
template <typename Rms>
std::vector<RelativeDeviation> ring(const Rms& rms) {
  std::vector<RelativeDeviation> pairs;
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t step = 1; step <= 2; ++step) {
      const std::size_t b = (a + step) % 8;
      pairs.push_back({a, b, rms(a, b) * (1.0 + 0.01 * static_cast<double>(pairs.size()))});
    }
  return pairs;
}

// As where every second image is mirrored.
TEST(DeviatingViews, AreThoseOfTheGroupThatFitsNoOther) {
  const auto found =
      find_deviating_views(8, ring([](std::size_t a, std::size_t b) {
                             return a == 7 || b == 7 ? 1.0 : (a + b) % 2 == 0 ? 1.0 : 2.5;
                           }));
  EXPECT_THAT(found.with_group, Each(false));  // View 7 fits both: all are one group.
  const auto halves = find_deviating_views(
      8, ring([](std::size_t a, std::size_t b) { return (a + b) % 2 == 0 ? 1.0 : 2.5; }));
  EXPECT_THAT(halves.with_group, ElementsAre(false, true, false, true, false, true, false, true));
  EXPECT_THAT(halves.alone, Each(false));
}

TEST(DeviatingViews, AreNoneWherePairsDeviateLittleMoreBetweenGroups) {
  const auto found = find_deviating_views(
      8, ring([](std::size_t a, std::size_t b) { return (a + b) % 2 == 0 ? 1.0 : 1.8; }));
  EXPECT_THAT(found.with_group, Each(false));
}

TEST(DeviatingViews, AreNoneWhereSomePairsOfOneGroupDeviateAsMuch) {
  const auto found = find_deviating_views(
      8, ring([](std::size_t a, std::size_t b) { return (a + b) % 2 == 0 && a != 2 ? 1.0 : 2.5; }));
  EXPECT_THAT(found.with_group, Each(false));
}

TEST(DeviatingViews, AreOneAlone) {
  const auto found = find_deviating_views(
      8, ring([](std::size_t a, std::size_t b) { return a == 3 || b == 3 ? 3.0 : 1.0; }));
  EXPECT_THAT(found.alone, ElementsAre(false, false, false, true, false, false, false, false));
}

}  // namespace
}  // namespace relief::registration
