#include "scan/grid/binned_view.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

using testing::plane;
using testing::render;
using testing::value_of;

constexpr int kWidth = 62, kHeight = 50, kFactor = 4;  // Neither size is a multiple of the factor.

std::vector<Camera> cameras() {
  return {Camera::pinhole(kWidth, kHeight, {100, 110, 30, 26}),
          Camera::pinhole_gl(kWidth, kHeight, {100, 110, 30, 26}),
          Camera::orthographic(kWidth, kHeight, {-30, -25, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}),
          Camera::spherical(SphericalProjection::even(kWidth, kHeight, -0.3, 0.01, -0.25, 0.01))};
}

// Faces the camera, whatever side it looks to.
RangeView slanted_plane(const Camera& camera) {
  const Eigen::Vector3d middle = camera.ray(kWidth / 2, kHeight / 2).at(100.0);
  const Eigen::Vector3d across = camera.ray(0, 0).at(100.0) - middle;
  return render(plane(middle, -middle.normalized() + 0.004 * across), camera);
}

TEST(BinnedView, LargePixelsLookBetweenTheSmallOnes) {
  for (const Camera& camera : cameras()) {
    const Camera binned = value_of(camera.binned(kFactor));
    EXPECT_EQ(binned.width(), kWidth / kFactor);
    EXPECT_EQ(binned.height(), kHeight / kFactor);
    const double middle = (kFactor - 1) / 2.0;
    for (const auto& [u, v] : {std::pair{0, 0}, {7, 3}, {14, 11}}) {
      const Ray large = binned.ray(u, v);
      const Ray small = camera.ray_at(u * kFactor + middle, v * kFactor + middle);
      EXPECT_TRUE(large.at(10.0).isApprox(small.at(10.0), 1e-9)) << to_string(camera.model());
      const Eigen::Vector2d pixel = value_of(binned.project(large.at(10.0)));
      EXPECT_NEAR((pixel - Eigen::Vector2d(u, v)).norm(), 0.0, 1e-6);
    }
    EXPECT_FALSE(camera.binned(1));
    EXPECT_FALSE(camera.binned(kHeight));
  }
}

TEST(BinnedView, APlaneStaysThePlane) {
  for (const Camera& camera : cameras()) {
    const RangeView view = slanted_plane(camera);
    const RangeView binned = value_of(bin_view(view, kFactor));
    EXPECT_EQ(binned.sample_count(), binned.range.size());
    for (int v = 0; v < binned.height(); ++v) {
      for (int u = 0; u < binned.width(); ++u) {
        const double off =
            view.normals(0, 0).cast<double>().dot(binned.point(u, v) - view.point(0, 0));
        EXPECT_NEAR(off, 0.0, 0.03) << to_string(camera.model()) << " at " << u << ", " << v;
        EXPECT_TRUE(binned.normals(u, v).isApprox(view.normals(0, 0), 1e-5f));
      }
    }
    EXPECT_NEAR(rough_spacing(binned) / rough_spacing(view), kFactor, 0.2);
  }
}

TEST(BinnedView, PartsOfAPlaneStayOnThePlane) {
  RangeView view = slanted_plane(cameras()[2]);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u)
      if (u % kFactor > v % kFactor) view.range(u, v) = kNoSample;  // 10 of 16 are left.
  const RangeView binned = value_of(bin_view(view, kFactor));
  EXPECT_EQ(binned.sample_count(), binned.range.size());
  const RangeView whole = value_of(bin_view(slanted_plane(cameras()[2]), kFactor));
  for (std::size_t i = 0; i < binned.range.size(); ++i)
    EXPECT_NEAR(binned.range[i], whole.range[i], 1e-9);
}

TEST(BinnedView, FewerThanHalfOfTheSamplesMakeNone) {
  RangeView view = slanted_plane(cameras()[0]);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u)
      if (u % kFactor + v % kFactor > 2) view.range(u, v) = kNoSample;  // 6 of 16 are left.
  EXPECT_EQ(value_of(bin_view(view, kFactor)).sample_count(), 0u);
}

TEST(BinnedView, NoSampleHangsBetweenTwoSurfaces) {
  RangeView view = render(plane({0, 0, 100}, {0, 0, -1}), cameras()[0]);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u)
      if (u > 29 + v / 9) view.range(u, v) = 130.0;
  const RangeView binned = value_of(bin_view(view, kFactor));
  EXPECT_EQ(binned.sample_count(), binned.range.size());
  for (const double range : binned.range)
    EXPECT_TRUE(std::abs(range - 100.0) < 1e-9 || std::abs(range - 130.0) < 1e-9) << range;
}

TEST(BinnedView, NoiseIsAveraged) {
  RangeView view = slanted_plane(cameras()[2]);
  const RangeView exact = value_of(bin_view(view, kFactor));
  testing::add_range_noise(view, 0.2, 5);
  view.deviation = Grid<float>(kWidth, kHeight, 0.2f);
  const RangeView binned = value_of(bin_view(view, kFactor));
  double squares = 0.0;
  for (std::size_t i = 0; i < binned.range.size(); ++i)
    squares += std::pow(binned.range[i] - exact.range[i], 2);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(binned.range.size())), 0.2 / kFactor, 0.01);
  EXPECT_NEAR(binned.deviation(3, 3), 0.2 / kFactor, 1e-6);
  view.samples = SampleOrigin::kRefined;
  EXPECT_NEAR(value_of(bin_view(view, kFactor)).deviation(3, 3), 0.2, 1e-6);
}

TEST(BinnedView, TakesColoursConfidenceAndPose) {
  RangeView view = slanted_plane(cameras()[0]);
  view.name = "v7";
  view.pose = PoseKind::kGuess;
  view.world_from_view.translation() = Eigen::Vector3d(1, 2, 3);
  view.confidence = Grid<float>(kWidth, kHeight, 0.0f);
  view.colours = Grid<Colour>(kWidth, kHeight, Colour{0, 100, 255});
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; u += 2) {
      view.confidence(u, v) = 1.0f;
      view.colours(u, v) = Colour{200, 100, 255};
    }
  const RangeView binned = value_of(bin_view(view, kFactor));
  EXPECT_EQ(binned.name, "v7");
  EXPECT_EQ(binned.pose, PoseKind::kGuess);
  EXPECT_EQ(binned.world_from_view.translation(), view.world_from_view.translation());
  EXPECT_FLOAT_EQ(binned.confidence(5, 5), 0.5f);
  EXPECT_EQ(binned.colours(5, 5), (Colour{100, 100, 255}));
}

TEST(BinnedView, ATableOfRaysIsLeftAsItIs) {
  const Grid<Ray> rays(kWidth, kHeight, {{0, 0, 0}, {0, 0, 1}});
  RangeView view;
  view.camera = Camera::ray_table(rays, std::optional<RationalProjection>());
  view.range = Grid<double>(kWidth, kHeight, 1.0);
  EXPECT_FALSE(bin_view(view, kFactor));
}

}  // namespace
}  // namespace relief
