#include "scan/evaluation/poses/pose_bound.h"

#include <gtest/gtest.h>

#include "tests/support/scenes/synthetic_views.h"

namespace relief::evaluation {
namespace {

constexpr double kSigma = 0.2;

// Two looks at the plane z = 10 on one grid of unit spacing.
std::vector<RangeView> two_looks(int size) {
  const double half = 0.5 * (size - 1);
  const Camera camera =
      Camera::orthographic(size, size, {-half, -half, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
  const RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), camera);
  return {view, view};
}

// Samples of both views, of variance sigma^2 each, lie on one unknown plane: their differences, of
// variance 2 sigma^2, are what is known.
TEST(PoseBound, OfTwoLooksAtAPlaneIsThatOfTheirDifferences) {
  const int size = 20;
  const auto information = pose_information(two_looks(size), kSigma, {0, 0, 10});
  const double expected = size * size / (2.0 * kSigma * kSigma);
  EXPECT_NEAR(information(5, 5), expected, 1e-9 * expected);
  EXPECT_NEAR(information(11, 11), expected, 1e-9 * expected);
  EXPECT_NEAR(information(5, 11), -expected, 1e-9 * expected);
  // Turning about x moves a sample along the normal by its y: the sum of y^2.
  const double moment = size * size * (size * size - 1.0) / 12.0 / (2.0 * kSigma * kSigma);
  EXPECT_NEAR(information(0, 0), moment, 1e-9 * moment);
  // A plane slides in itself.
  EXPECT_NEAR(information(2, 2), 0.0, 1e-9 * expected);
  EXPECT_NEAR(information(3, 3), 0.0, 1e-9 * expected);
}

TEST(PoseBound, OneViewAloneKnowsNothing) {
  auto views = two_looks(10);
  views.pop_back();
  EXPECT_TRUE(pose_information(views, kSigma, Eigen::Vector3d::Zero()).isZero());
}

TEST(PoseBound, MovingAllViewsAlikeCannotBeSeen) {
  const Camera camera = Camera::pinhole(60, 60, {80, 80, 29.5, 29.5});
  std::vector<RangeView> views;
  for (const double x : {-3.0, 0.0, 3.0})
    views.push_back(testing::render(testing::sphere({0, 0, 10}, 3.0), camera,
                                    testing::look_at({x, 0.5 * x, 0}, {0, 0, 10})));
  const auto information = pose_information(views, kSigma, {0, 0, 10});
  EXPECT_GT(information.norm(), 0.0);
  Eigen::VectorXd all(18);
  for (int i = 0; i < 3; ++i) all.segment<6>(6 * i) << 0.1, -0.2, 0.3, 1.0, 2.0, -1.0;
  EXPECT_LT((information * all).norm(), 1e-9 * information.norm());
}

}  // namespace
}  // namespace relief::evaluation
