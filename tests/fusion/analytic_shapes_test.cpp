// Exact views of shapes that are hard to merge: what must be there is there, and nothing else.

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "relief/fusion/merge_views.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

using testing::box_distance;
using testing::SignedDistance;
using testing::torus_distance;
using testing::traced;
using testing::views_around;

SignedDistance moved(SignedDistance shape, const Eigen::Vector3d& to) {
  return [=](const Eigen::Vector3d& p) { return shape(p - to); };
}

SignedDistance united(SignedDistance a, SignedDistance b) {
  return [=](const Eigen::Vector3d& p) { return std::min(a(p), b(p)); };
}

SignedDistance without(SignedDistance a, SignedDistance b) {
  return [=](const Eigen::Vector3d& p) { return std::max(a(p), -b(p)); };
}

// A bar upright along z, round or square.
SignedDistance rod(double radius, double half_length) {
  return [=](const Eigen::Vector3d& p) {
    return std::max(p.head<2>().norm() - radius, std::abs(p.z()) - half_length);
  };
}

struct Errors {
  double rms = 0.0, largest = 0.0;  // Of measured vertices [voxels].
};

Errors errors_of(const MergeResult& result, const SignedDistance& distance) {
  Errors errors;
  double squares = 0.0, count = 0.0;
  for (std::size_t v = 0; v < result.mesh.vertices.size(); ++v) {
    if (result.mesh.filled[v]) continue;
    const double error = std::abs(distance(result.mesh.vertices[v])) / result.voxel_size;
    squares += error * error;
    errors.largest = std::max(errors.largest, error);
    count += 1.0;
  }
  errors.rms = std::sqrt(squares / count);
  return errors;
}

MergeResult merged(const std::vector<RangeView>& views, const MergeOptions& options = {}) {
  auto result = value_of(merge_views(views, options));
  EXPECT_TRUE(result.check.watertight());
  return result;
}

TEST(AnalyticShapes, ATorusConvergesWithTheSquareOfTheResolution) {
  const SignedDistance torus = torus_distance(35.0, 12.0);
  double last = 0.0;
  for (const int size : {40, 80, 160}) {
    const MergeResult result = merged(views_around(traced(torus), 14, size, 50.0));
    EXPECT_EQ(result.check.genus, 1);
    const double rms = errors_of(result, torus).rms * result.voxel_size;
    if (last > 0.0) {
      EXPECT_GT(last / rms, 3.8);
    }
    last = rms;
  }
}

TEST(AnalyticShapes, ABoxIsRoundedByLessThanHalfAVoxelAtItsEdges) {
  const SignedDistance box = box_distance({30.0, 25.0, 20.0});
  for (const int size : {60, 120}) {
    const MergeResult result = merged(views_around(traced(box), 14, size, 50.0));
    EXPECT_EQ(result.check.genus, 0);
    EXPECT_LT(errors_of(result, box).largest, 0.6) << "nothing off the box";
    // And the box reaches as far: the edges' true points have a vertex nearby.
    for (double x = -28.0; x <= 28.0; x += 4.0) {
      const Eigen::Vector3d on_edge(x, 25.0, 20.0);
      double nearest = 1e9;
      for (const auto& p : result.mesh.vertices) nearest = std::min(nearest, (p - on_edge).norm());
      EXPECT_LT(nearest, result.voxel_size);
    }
  }
}

TEST(AnalyticShapes, TwoSpheresThatTouchAreBothThere) {
  const SignedDistance ball = testing::sphere_distance(22.0);
  const SignedDistance pair = united(moved(ball, {22, 0, 0}), moved(ball, {-22, 0, 0}));
  MergeOptions options;
  options.keep_components = true;  // apart or joined at the point: the lattice decides
  const MergeResult result = merged(views_around(traced(pair), 14, 100, 45.0), options);
  EXPECT_EQ(result.check.genus, 0);
  EXPECT_LE(result.check.components, 2u);
  const double volume = 2.0 * 4.0 / 3.0 * std::numbers::pi * std::pow(22.0, 3);
  EXPECT_NEAR(result.check.volume / volume, 1.0, 0.01);
  EXPECT_LT(errors_of(result, pair).rms, 0.05);
}

TEST(AnalyticShapes, APlateOfThreeSpacingsKeepsItsThickness) {
  auto spacing_of = [](double thickness) {
    return merged(views_around(traced(box_distance({30.0, 25.0, 0.5 * thickness})), 20, 120, 40.0))
        .voxel_size;
  };
  const double thickness = 3.0 * spacing_of(3.0);
  const SignedDistance plate = box_distance({30.0, 25.0, 0.5 * thickness});
  const MergeResult result = merged(views_around(traced(plate), 20, 120, 40.0));
  EXPECT_EQ(result.check.genus, 0);
  EXPECT_EQ(result.check.components, 1u);
  EXPECT_NEAR(result.check.volume / (60.0 * 50.0 * thickness), 1.0, 0.02);
  EXPECT_LT(errors_of(result, plate).largest, 1.0);
}

TEST(AnalyticShapes, ADeepHoleKeepsItsDepth) {
  // A bore 20 wide and 40 deep; two views look straight down into it.
  const SignedDistance block =
      without(box_distance({25.0, 25.0, 25.0}), moved(rod(10.0, 20.0), {0, 0, 6}));
  auto views = views_around(traced(block), 24, 110, 45.0);
  const Camera& camera = views[0].camera;
  for (const double tilt : {-0.1, 0.1})
    views.push_back(render(traced(block), camera,
                           testing::look_at(270.0 * Eigen::Vector3d(tilt, 0.02, 1.0).normalized(),
                                            Eigen::Vector3d::Zero())));
  const MergeResult result = merged(views);
  EXPECT_EQ(result.check.genus, 0);
  EXPECT_EQ(result.check.components, 1u);
  const double volume = std::pow(50.0, 3) - std::numbers::pi * 100.0 * 39.0;
  EXPECT_NEAR(result.check.volume / volume, 1.0, 0.01);
  bool bottom = false;
  for (const auto& p : result.mesh.vertices)
    bottom |= p.head<2>().norm() < 3.0 && std::abs(p.z() + 14.0) < 0.2 * result.voxel_size;
  EXPECT_TRUE(bottom) << "the floor of the bore is in its place";
  EXPECT_LT(errors_of(result, block).rms, 0.1);
}

TEST(AnalyticShapes, LettersInReliefAreLegible) {
  // T and L, 2 raised above a slab of 50 x 40; strokes 4 wide.
  SignedDistance slab = box_distance({25.0, 20.0, 6.0});
  const auto stroke = [&](double x, double y, double w, double h) {
    slab = united(slab, moved(box_distance({0.5 * w, 0.5 * h, 4.0}), {x, y, 4.0}));
  };
  stroke(-12, 10, 16, 4), stroke(-12, 0, 4, 24);
  stroke(8, 0, 4, 24), stroke(13, -10, 14, 4);
  const MergeResult result = merged(views_around(traced(slab), 20, 160, 35.0));
  EXPECT_EQ(result.check.genus, 0);
  const Errors errors = errors_of(result, slab);
  EXPECT_LT(errors.rms, 0.1);
  EXPECT_LT(errors.largest, 1.0);
  // All of the strokes' tops are at 8, all of the ground between them at 6.
  std::size_t tops = 0, grounds = 0;
  for (const auto& p : result.mesh.vertices) {
    const double up = p.z();
    if (box_distance({7.0, 1.0, 4.0})(p - Eigen::Vector3d(-12, 10, 7)) < 0.0) {
      EXPECT_NEAR(up, 8.0, 0.15 * result.voxel_size);
      ++tops;
    }
    if (box_distance({4.0, 8.0, 4.0})(p - Eigen::Vector3d(-2, -2, 7)) < 0.0) {
      EXPECT_NEAR(up, 6.0, 0.15 * result.voxel_size);
      ++grounds;
    }
  }
  EXPECT_GT(tops, 30u);
  EXPECT_GT(grounds, 30u);
}

}  // namespace
}  // namespace relief::fusion
