#include "registration/verification/common_errors.h"

#include <gtest/gtest.h>

#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

class CommonErrorsTest : public ::testing::Test {
 protected:
  static const std::vector<ViewSurface>& surfaces() {
    static const auto views = testing::ring_of_views({.views = 4, .pixels = 64});
    static const auto surfaces = [] {
      std::vector<ViewSurface> list;
      for (const RangeView& view : views) list.emplace_back(view);
      return list;
    }();
    return surfaces;
  }

  static double noise() { return joint_noise(surfaces()[0], surfaces()[1]); }
  static double spacing() { return coarser_spacing(surfaces()[0], surfaces()[1]); }
};

TEST_F(CommonErrorsTest, AreNoneWhereTheNoiseExplainsThem) {
  const double rms = 1.2 * noise();
  EXPECT_EQ(common_stddev(surfaces(), {{0, 1, rms}, {1, 2, rms}, {2, 3, rms}}), 0.0);
  EXPECT_EQ(common_stddev(surfaces(), {}), 0.0);
}

TEST_F(CommonErrorsTest, AreThoseOfTheBetterQuarterOfThePairs) {
  const double right = 2.0 * spacing();
  std::vector<PairDeviation> pairs;
  for (int k = 0; k < 6; ++k) pairs.push_back({0, 1, right});
  for (int k = 0; k < 14; ++k) pairs.push_back({1, 2, 10.0 * right});
  EXPECT_DOUBLE_EQ(common_stddev(surfaces(), pairs), right);
}

}  // namespace
}  // namespace relief::registration
