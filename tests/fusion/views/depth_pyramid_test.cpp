#include "fusion/views/depth_pyramid.h"

#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace relief::fusion {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();

TEST(DepthPyramid, IsNeverBelowAnyPixelOfARectangleNorAboveAll) {
  std::mt19937 random(3);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  Grid<float> depths(37, 22, kNothing);
  for (int i = 0; i < 300; ++i) depths(below(37), below(22)) = static_cast<float>(below(1000));
  float most = kNothing;
  for (const float depth : depths) most = std::max(most, depth);
  const DepthPyramid pyramid(depths);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector2i low(below(60) - 10, below(50) - 10);
    const Eigen::Vector2i high = low + Eigen::Vector2i(below(30), below(30));
    float exact = kNothing;
    for (int v = std::max(0, low.y()); v <= std::min(21, high.y()); ++v)
      for (int u = std::max(0, low.x()); u <= std::min(36, high.x()); ++u)
        exact = std::max(exact, depths(u, v));
    const float found = pyramid.greatest({low, high});
    EXPECT_GE(found, exact);
    EXPECT_LE(found, most);
    if ((high - low).maxCoeff() <= 2) {
      EXPECT_EQ(found, exact) << "small rectangles are looked at pixel by pixel";
    }
  }
}

TEST(DepthPyramid, HasNothingOutsideOfTheGridAndWhenEmpty) {
  const DepthPyramid pyramid(Grid<float>(4, 3, 1.0f));
  using Pixel = Eigen::Vector2i;
  EXPECT_EQ(pyramid.greatest({Pixel(4, 0), Pixel(9, 2)}), kNothing);
  EXPECT_EQ(pyramid.greatest({Pixel(-5, -5), Pixel(-1, 2)}), kNothing);
  EXPECT_EQ(pyramid.greatest({Pixel(-5, -5), Pixel(100, 100)}), 1.0f);
  EXPECT_EQ(DepthPyramid().greatest({Pixel(0, 0), Pixel(1, 1)}), kNothing);
}

}  // namespace
}  // namespace relief::fusion
