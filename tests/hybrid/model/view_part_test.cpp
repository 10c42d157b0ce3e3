// Parts of views, and views put together from them again.

#include "hybrid/model/view_part.h"

#include <cmath>

#include <gtest/gtest.h>

#include "relief/hybrid/refine_view.h"
#include "tests/hybrid/bumpy_view.h"
#include "tests/support/degree.h"
#include "tests/support/geometry_matchers.h"
#include "tests/support/parameter_names.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::hybrid {
namespace {

constexpr int kWidth = 60, kHeight = 50;

Camera table_of(const Camera& camera) {
  Grid<Ray> rays(camera.width(), camera.height());
  for (int v = 0; v < camera.height(); ++v)
    for (int u = 0; u < camera.width(); ++u) rays(u, v) = camera.ray(u, v);
  return Camera::ray_table(rays, std::nullopt);
}

std::vector<Camera> cameras() {
  const PinholeIntrinsics k{80.0, 70.0, 30.0, 20.0};
  return {Camera::pinhole(kWidth, kHeight, k), Camera::pinhole_gl(kWidth, kHeight, k),
          Camera::orthographic(kWidth, kHeight, {1, 2, 0}, {0.5, 0, 0}, {0, 0.4, 0}, {0, 0, 1}),
          table_of(Camera::pinhole(kWidth, kHeight, k))};
}

class ViewPartOfCamera : public ::testing::TestWithParam<Camera> {};
INSTANTIATE_TEST_SUITE_P(Cameras, ViewPartOfCamera, ::testing::ValuesIn(cameras()),
                         testing::PrintedName());

// A view with samples at three pixels.
RangeView view_of(const Camera& camera) {
  RangeView view;
  view.name = "spots";
  view.camera = camera;
  view.range = Grid<double>(kWidth, kHeight, kNoSample);
  view.range(12, 20) = 100.0;
  view.range(40, 8) = 101.0;
  view.range(30, 33) = 102.0;
  return view;
}

TEST_P(ViewPartOfCamera, HasTheSamePoints) {
  const RangeView view = view_of(GetParam());
  const ViewPart part = part_with_samples(view, 3);
  EXPECT_EQ(part.u, 8) << "9 would do; blocks of 8 begin here";
  EXPECT_EQ(part.v, 0);
  EXPECT_EQ(part.width, 40 + 3 - 8 + 1);
  EXPECT_EQ(part.height, 33 + 3 + 1);
  const RangeView cropped = crop(view, part);
  ASSERT_EQ(cropped.width(), part.width);
  ASSERT_EQ(cropped.sample_count(), 3u);
  for (int v = 0; v < part.height; ++v)
    for (int u = 0; u < part.width; ++u)
      if (cropped.has_sample(u, v)) {
        EXPECT_LT((cropped.point(u, v) - view.point(part.u + u, part.v + v)).norm(), 1e-12);
      }
}

TEST_P(ViewPartOfCamera, IsPutBackWhereItWas) {
  RangeView view = view_of(GetParam());
  view.confidence = Grid<float>(kWidth, kHeight, 0.5f);
  const ViewPart part = part_with_samples(view, 3);
  RangeView changed = crop(view, part);
  for (double& range : changed.range) range += 1.0;
  changed.deviation = Grid<float>(part.width, part.height, 0.25f);
  changed.samples = SampleOrigin::kRefined;
  const RangeView whole = with_part(view, part, changed);
  EXPECT_EQ(whole.camera.model(), view.camera.model());
  EXPECT_EQ(whole.name, "spots");
  EXPECT_EQ(whole.samples, SampleOrigin::kRefined);
  EXPECT_EQ(whole.sample_count(), 3u);
  EXPECT_EQ(whole.range(40, 8), 102.0);
  EXPECT_EQ(whole.confidence(0, 0), 0.5f);
  EXPECT_EQ(whole.confidence(40, 8), 0.5f);
  EXPECT_EQ(whole.deviation(40, 8), 0.25f);
  EXPECT_TRUE(std::isnan(whole.deviation(0, 0)));
  EXPECT_TRUE(whole.normals.empty());
}

TEST(ViewPart, StaysInTheGridAndIsEmptyWithoutSamples) {
  RangeView view = view_of(cameras()[0]);
  const ViewPart part = part_with_samples(view, 100);
  EXPECT_EQ(part.width, kWidth);
  EXPECT_EQ(part.height, kHeight);
  view.range = Grid<double>(kWidth, kHeight, kNoSample);
  EXPECT_EQ(part_with_samples(view, 3).width, 0);
}

// A masked view is refined by its part alone; one sample in each corner makes it a full one.
TEST(ViewPart, IsRefinedAsInTheWholeView) {
  constexpr int kSize = 192;
  RangeView view = testing::render(testing::bumpy_surface(), testing::bumpy_camera(kSize, kSize));
  testing::add_range_noise(view, 0.3, 1);
  testing::add_normal_noise(view, testing::kDegree, 2);
  RangeView full = view;
  for (int v = 0; v < kSize; ++v)
    for (int u = 0; u < kSize; ++u) {
      if (std::hypot(u - 120, v - 70) < 45.0) continue;
      view.range(u, v) = kNoSample;
      const bool corner = (u == 0 || u == kSize - 1) && (v == 0 || v == kSize - 1);
      if (!corner) full.range(u, v) = kNoSample;
      view.normals(u, v) = full.normals(u, v).setConstant(static_cast<float>(kNoSample));
    }
  ASSERT_LT(part_with_samples(view, 16).width, 130);
  ASSERT_EQ(part_with_samples(full, 16).width, kSize);
  const RefinedView part = value_of(refine_view(view)), whole = value_of(refine_view(full));
  ASSERT_EQ(part.status, RefineStatus::kRefined);
  EXPECT_EQ(part.refined, whole.refined);
  EXPECT_EQ(part.replaced_normals, whole.replaced_normals);
  EXPECT_NEAR(part.sigma_position, whole.sigma_position, 1e-9);
  double part_deviations = 0.0, whole_deviations = 0.0;
  for (int v = 0; v < kSize; ++v)
    for (int u = 0; u < kSize; ++u) {
      if (!part.view.has_sample(u, v)) continue;
      EXPECT_NEAR(part.view.range(u, v), whole.view.range(u, v), 1e-4) << u << " " << v;
      EXPECT_LT((part.view.normals(u, v) - whole.view.normals(u, v)).norm(), 1e-4);
      part_deviations += part.view.deviation(u, v);
      whole_deviations += whole.view.deviation(u, v);
    }
  EXPECT_NEAR(part_deviations, whole_deviations, 0.02 * whole_deviations)
      << "of other random errors";
}

}  // namespace
}  // namespace relief::hybrid
