#include "scan/evaluation/base/error_colours.h"

#include <limits>

#include <gtest/gtest.h>

namespace relief::evaluation {
namespace {

TEST(ColoursOfErrors, GoFromBlueOverGreyToRed) {
  const auto colours = colours_of_errors({-9.0, -2.0, 0.0, 1.0, 2.0, 9.0}, 2.0);
  EXPECT_EQ(colours[0], colours[1]);
  EXPECT_GT(colours[1][2], colours[1][0] + 100);  // blue
  EXPECT_EQ(colours[2][0], colours[2][1]);
  EXPECT_EQ(colours[2][1], colours[2][2]);        // grey
  EXPECT_GT(colours[4][0], colours[4][2] + 100);  // red
  EXPECT_EQ(colours[4], colours[5]);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(colours[3][k], 0.5 * (colours[2][k] + colours[4][k]), 1);
}

TEST(ColoursOfErrors, MarkWhatIsNoNumber) {
  EXPECT_EQ(colours_of_errors({std::numeric_limits<double>::quiet_NaN()}, 1.0)[0],
            (Colour{0, 0, 0}));
}

}  // namespace
}  // namespace relief::evaluation
