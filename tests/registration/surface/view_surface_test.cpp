#include "registration/surface/view_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "scan/base/counter_random.h"
#include "tests/registration/bumpy_object.h"

namespace relief::registration {
namespace {

const Camera kCamera = Camera::pinhole(80, 60, {100, 100, 39.5, 29.5});

TEST(ViewSurface, InterpolatesAPlaneExactly) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, -1).normalized();
  const RangeView view = testing::render(testing::plane({0, 0, 10}, normal), kCamera);
  const ViewSurface surface(view);
  const auto found = surface.at({31.3, 22.8});
  ASSERT_TRUE(found.has_value());
  // The range is interpolated, whose inverse is what is linear on a plane.
  EXPECT_NEAR((found->point - Eigen::Vector3d(0, 0, 10)).dot(normal), 0.0, 1e-4);
  EXPECT_NEAR(found->normal.dot(normal), 1.0, 1e-6);
}

TEST(ViewSurface, BendsBetweenSamplesAsTheSurfaceDoes) {
  constexpr double kRadius = 1.0;  // Ten samples: the chord's sag is 1/800 of it.
  const Eigen::Vector3d centre(0, 0, 10);
  const RangeView view = testing::render(testing::sphere(centre, kRadius), kCamera);
  const ViewSurface surface(view);
  for (const auto& pixel : {Eigen::Vector2d(39.0, 29.0), Eigen::Vector2d(36.5, 31.5)}) {
    const auto found = surface.at(pixel);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR((found->point - centre).norm(), kRadius, 2e-4);
    const auto sample = surface.nearest(pixel);
    EXPECT_LE((sample->pixel - pixel).lpNorm<Eigen::Infinity>(), 0.5);
    EXPECT_NEAR((sample->point - centre).norm(), kRadius, 1e-6);
  }
}

TEST(ViewSurface, EndsBeforeBoundariesAndTheGridsBorder) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  for (int v = 0; v < 60; ++v) view.range(40, v) = kNoSample;
  const ViewSurface surface(view, {.boundary_margin = 2});
  EXPECT_FALSE(surface.at({38.5, 30.0}).has_value());
  EXPECT_TRUE(surface.at({35.5, 30.0}).has_value());
  EXPECT_FALSE(surface.at({0.5, 30.0}).has_value());
  EXPECT_FALSE(surface.at({-5.0, 30.0}).has_value());
  EXPECT_FALSE(surface.at({1e9, 30.0}).has_value());
}

TEST(ViewSurface, GoesFartherWhenAskedForTheWhole) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  for (int v = 0; v < 60; ++v) view.range(40, v) = kNoSample;
  const ViewSurface surface(view, {.boundary_margin = 3, .final_margin = 1});
  EXPECT_TRUE(surface.at({37.5, 30.0}, SurfacePart::kWhole).has_value());
  EXPECT_TRUE(surface.nearest({37.4, 30.0}, SurfacePart::kWhole).has_value());
  EXPECT_FALSE(surface.at({37.5, 30.0}).has_value());
  EXPECT_FALSE(surface.nearest({37.4, 30.0}).has_value());
  EXPECT_FALSE(surface.at({38.5, 30.0}, SurfacePart::kWhole).has_value());
  // Pixels 1 to 38 and 42 to 78 of rows 1 to 58, of which those off boundaries by three are inner.
  EXPECT_EQ(surface.samples().size(), (34u + 33u) * 54u);
  EXPECT_EQ(surface.edge_samples().size(), (38u + 37u) * 58u - (34u + 33u) * 54u);
  for (const std::uint32_t i : surface.edge_samples()) {
    const int u = static_cast<int>(i % 80), v = static_cast<int>(i / 80);
    EXPECT_NEAR((surface.sample(i).point - view.point(u, v)).norm(), 0.0, 1e-12);
  }
}

TEST(ViewSurface, DropsSamplesWithoutConfidence) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  view.confidence = Grid<float>(80, 60, 1.0f);
  view.confidence(20, 20) = 0.0f;
  const ViewSurface surface(view);
  EXPECT_FALSE(surface.at({19.5, 19.5}).has_value());
  EXPECT_TRUE(surface.at({22.5, 19.5}).has_value());
}

TEST(ViewSurface, TrustsSamplesByTheInverseOfTheirVariance) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  view.confidence = Grid<float>(80, 60, 0.5f);
  view.confidence(60, 20) = 0.0f;
  view.deviation = Grid<float>(80, 60, 0.01f);
  view.deviation(20, 20) = 0.02f;
  view.deviation(40, 20) = static_cast<float>(kNoSample);
  testing::add_range_noise(view, 0.01, 1);
  const ViewSurface surface(view);
  EXPECT_FLOAT_EQ(surface.at({30.0, 20.0})->confidence, 1.0);
  EXPECT_FLOAT_EQ(surface.at({20.0, 20.0})->confidence, 0.25);
  EXPECT_FLOAT_EQ(surface.at({40.0, 20.0})->confidence, 0.5);
  EXPECT_FALSE(surface.at({60.0, 20.0}).has_value());
}

// As refining leaves it: a smooth surface, of which no place is known well.
TEST(ViewSurface, DoesNotWeighByDeviationsOfErrorsThatNeighboursShare) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  view.deviation = Grid<float>(80, 60, 0.03f);
  view.deviation(20, 20) = 0.06f;
  view.samples = SampleOrigin::kRefined;
  testing::add_range_noise(view, 0.01, 1);
  EXPECT_DOUBLE_EQ(ViewSurface(view).at({20.0, 20.0})->confidence, 1.0);
}

TEST(ViewSurface, MeasuresTheNoiseOfAView) {
  for (const double sigma : {0.005, 0.03}) {  // Spacings are 0.06 to 0.1.
    RangeView view = testing::render(testing::sphere({0, 0, 10}, 4.0), kCamera);
    testing::add_range_noise(view, sigma, 1);
    // Along the normal, so a little less than along the ray.
    const ViewSurface surface(view);
    EXPECT_LT(surface.noise(), 1.1 * sigma);
    EXPECT_GT(surface.noise(), 0.6 * sigma);
  }
}

// Depth cameras of two eyes round the inverse of the range.
void round_inverse_ranges(RangeView& view, double step) {
  for (double& range : view.range) range = 1.0 / (std::round(1.0 / range / step) * step);
}

TEST(ViewSurface, IsOfTheSizeAndNoiseOfMostSamplesWhereSomeAreFarAway) {
  RangeView near = testing::render(testing::plane({0, 0, 1000}, {0.3, 0.1, -1}), kCamera);
  testing::add_range_noise(near, 0.5, 1);
  RangeView with_far = near;
  for (int v = 0; v < 60; ++v)
    for (int u = 0; u < 16; ++u) with_far.range(u, v) = 25000.0 + 150.0 * u + 40.0 * v;
  for (RangeView* view : {&near, &with_far}) round_inverse_ranges(*view, 1e-6);  // 1 mm at 1 m.
  const ViewSurface alone(near), surface(with_far);
  EXPECT_LT(surface.radius(), 1.1 * alone.radius());
  EXPECT_LT(surface.noise(), 2.0 * alone.noise());
  EXPECT_LT(surface.rounding(), 2.0 * alone.rounding());
  EXPECT_GT(surface.samples().size(), (80u - 16u - 12u) * (60u - 12u));
  for (const std::uint32_t i : surface.samples()) EXPECT_LT(surface.sample(i).point.z(), 2000.0);
  // What lies before it stands in space seen empty.
  EXPECT_TRUE(surface.at({6.5, 30.0}).has_value());
}

// One wrong range in twenty leaves a third of the pixels with a whole neighbourhood of 5 x 5.
TEST(ViewSurface, BridgesSingleWrongRangesInsideASurface) {
  const RangeView clean = testing::render(testing::plane({0, 0, 10}, {0.2, 0, -1}), kCamera);
  RangeView view = clean;
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < view.range.size(); ++i) {
    const std::uint64_t random = CounterRandom::scrambled(i);
    if (random % 20 != 0) continue;
    view.range[i] *= random % 3 == 0 ? 0.7 : 1.4;
    ++wrong;
  }
  ASSERT_GT(wrong, view.range.size() / 25);
  const ViewSurface surface(view);
  EXPECT_GT(surface.samples().size(), ViewSurface(clean).samples().size() * 85 / 100);
  for (const std::uint32_t i : surface.samples())
    EXPECT_LT((surface.sample(i).point - clean.point(static_cast<int>(i) % clean.width(),
                                                     static_cast<int>(i) / clean.width()))
                  .norm(),
              1e-9);
}

TEST(ViewSurface, KeepsTheRoundingOfARangeThatWasCorrected) {
  const RangeView given = [] {
    RangeView view = testing::render(testing::plane({0, 0, 1000}, {0.3, 0.1, -1}), kCamera);
    round_inverse_ranges(view, 2e-5);  // 20 mm at 1 m.
    return view;
  }();
  RangeView corrected = given;
  for (int v = 0; v < given.height(); ++v)
    for (int u = 0; u < given.width(); ++u) corrected.range(u, v) *= 1.0 + 1e-4 * u - 7e-5 * v;
  const ViewSurface of_given(given), anew(corrected);
  const ViewSurface kept(corrected, estimate_range_noise(given));
  EXPECT_GT(of_given.rounding(), 0.0);
  EXPECT_EQ(anew.rounding(), 0.0);
  EXPECT_NEAR(kept.rounding(), of_given.rounding(), 0.05 * of_given.rounding());
}

TEST(ViewSurface, EveryPrefixOfTheSamplesCoversTheSurface) {
  const RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  const ViewSurface surface(view);
  int quadrants[4] = {};
  for (std::size_t i = 0; i < 400; ++i) {
    const Eigen::Vector3d p = surface.sample(surface.samples()[i]).point;
    ++quadrants[(p.x() > 0) + 2 * (p.y() > 0)];
  }
  for (const int count : quadrants) EXPECT_NEAR(count, 100, 35);
}

TEST(ViewSurface, ClosestPointsAgreeWithTheProjectedOnes) {
  testing::RingOptions ring;
  ring.views = 1;
  ring.noise = 0.0;
  const RangeView view = testing::ring_of_views(ring).front();
  const ViewSurface surface(view, {.neighbour_index = true});
  Eigen::Matrix3Xd queries(3, 200);
  for (int i = 0; i < 200; ++i) {
    const SurfacePoint s = surface.sample(surface.samples()[static_cast<std::size_t>(i)]);
    queries.col(i) = s.point + 0.2 * surface.spacing() * s.normal;
  }
  const auto pixels = surface.closest(queries);
  int compared = 0;
  for (int i = 0; i < 200; ++i) {
    const auto closest = surface.at(pixels[static_cast<std::size_t>(i)]);
    const auto seen = surface.at(*surface.project(queries.col(i)));
    if (!closest || !seen) continue;
    ++compared;
    const double by_closest = closest->normal.dot(queries.col(i) - closest->point);
    const double by_projection = seen->normal.dot(queries.col(i) - seen->point);
    EXPECT_NEAR(by_closest, by_projection, 0.05 * surface.spacing());
  }
  EXPECT_GT(compared, 150);
}

TEST(ViewSurface, OfAnEmptyViewHasNoSamples) {
  RangeView view = testing::render(testing::plane({0, 0, 10}, {0, 0, -1}), kCamera);
  std::fill(view.range.begin(), view.range.end(), kNoSample);
  const ViewSurface surface(view, {.neighbour_index = true});
  EXPECT_TRUE(surface.samples().empty());
  EXPECT_FALSE(surface.at({30.5, 30.5}).has_value());
}

}  // namespace
}  // namespace relief::registration
