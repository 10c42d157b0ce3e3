#include "scan/grid/filled_view.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/scenes/synthetic_views.h"

namespace relief {
namespace {

constexpr int kSide = 120;
const Camera kCamera = Camera::pinhole(kSide, kSide, {400.0, 400.0, 59.5, 59.5});

RangeView ball(double noise) {
  RangeView view = testing::render(testing::sphere({0, 0, 400}, 100.0), kCamera);
  testing::add_range_noise(view, noise, 5);
  return view;
}

void lose_samples(RangeView& view, double part) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  for (std::size_t i = 0; i < view.range.size(); ++i) {
    if (chance(generator) >= part) continue;
    view.range[i] = kNoSample;
    view.normals[i].setConstant(static_cast<float>(kNoSample));
  }
}

TEST(FilledView, LosesNothingToSamplesMissingAtRandom) {
  const RangeView truth = ball(0.0);
  RangeView view = ball(0.1);
  lose_samples(view, 0.15);
  const FilledView filled = fill_small_gaps(view);
  EXPECT_EQ(filled.flying, 0u);
  EXPECT_GT(filled.view.sample_count(), 0.99 * static_cast<double>(truth.sample_count()));
  EXPECT_EQ(filled.view.sample_count(), view.sample_count() + filled.filled_count);
  double squares = 0.0, angles = 0.0;
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      if (view.has_sample(u, v)) {
        EXPECT_EQ(filled.view.range(u, v), view.range(u, v));
        EXPECT_FALSE(filled.filled(u, v));
      }
      if (!filled.filled(u, v)) continue;
      squares += std::pow(filled.view.range(u, v) - truth.range(u, v), 2);
      angles += filled.view.normals(u, v).dot(truth.normals(u, v));
    }
  }
  const auto count = static_cast<double>(filled.filled_count);
  EXPECT_LT(std::sqrt(squares / count), 0.1);
  EXPECT_GT(angles / count, std::cos(0.01));
}

TEST(FilledView, TakesFlyingSamplesAway) {
  const RangeView truth = ball(0.0);
  RangeView view = ball(0.1);
  std::mt19937 generator(3);
  std::normal_distribution<double> far(0.0, 20.0);
  std::size_t flying = 0;
  for (int v = 5; v < kSide; v += 7) {
    for (int u = 5; u < kSide; u += 7) {
      const double error = far(generator);
      if (!view.has_sample(u, v) || std::abs(error) < 5.0) continue;
      view.range(u, v) += error;
      ++flying;
    }
  }
  const FilledView filled = fill_small_gaps(view);
  EXPECT_NEAR(static_cast<double>(filled.flying), static_cast<double>(flying), 0.05 * flying);
  EXPECT_GE(filled.flying, filled.filled_count);
  double squares = 0.0;
  std::size_t count = 0;
  for (int v = 10; v < kSide - 10; ++v) {
    for (int u = 10; u < kSide - 10; ++u) {
      if (!filled.view.has_sample(u, v)) continue;
      squares += std::pow(filled.view.range(u, v) - truth.range(u, v), 2);
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), 0.15);
}

TEST(FilledView, KeepsIslandsBetweenMissingSamples) {
  for (const int period : {2, 4, 6}) {
    RangeView view = ball(0.1);
    for (int v = 0; v < kSide; ++v)
      for (int u = 0; u < kSide; ++u)
        if (2 * (u % period) >= period || 2 * (v % period) >= period) view.range(u, v) = kNoSample;
    const FilledView filled = fill_small_gaps(view);
    EXPECT_EQ(filled.flying, 0u);
    EXPECT_EQ(filled.filled_count, 0u);
  }
}

TEST(FilledView, KeepsHolesAndOcclusionEdges) {
  RangeView view = testing::render(testing::plane({0, 0, 400}, {0, 0, 1}), kCamera);
  testing::add_range_noise(view, 0.1, 5);
  for (int v = 0; v < kSide; ++v)
    for (int u = 60; u < kSide; ++u) view.range(u, v) += 30.0;
  for (int v = 0; v < kSide; ++v) view.range(60, v) = kNoSample;
  for (int v = 20; v < 26; ++v)
    for (int u = 20; u < 26; ++u) view.range(u, v) = kNoSample;
  const FilledView filled = fill_small_gaps(view);
  for (int v = 0; v < kSide; ++v) EXPECT_FALSE(filled.view.has_sample(60, v));
  EXPECT_FALSE(filled.view.has_sample(23, 23));
  EXPECT_EQ(filled.filled_count, 0u);
}

TEST(FilledView, KeepsRoundHolesWhole) {
  RangeView view = ball(0.1);
  for (int v = 50; v < 70; ++v)
    for (int u = 50; u < 70; ++u)
      if (std::hypot(u - 60, v - 60) < 3.5) view.range(u, v) = kNoSample;
  EXPECT_EQ(fill_small_gaps(view).filled_count, 0u);
}

// A depth map carried into the image of a finer camera misses rows and columns, and here a hole.
TEST(FilledView, FillsALatticeOfMissingLinesBesideHoles) {
  const RangeView truth = ball(0.0);
  RangeView view = truth;
  const auto hole = [](int u, int v) { return std::hypot(u - 60, v - 70) < 8.0; };
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      if (u % 4 != 1 && v % 5 != 1 && !hole(u, v)) continue;
      view.range(u, v) = kNoSample;
      view.normals(u, v).setConstant(static_cast<float>(kNoSample));
    }
  }
  const FilledView filled = fill_small_gaps(view);
  for (int v = 2; v < kSide - 2; ++v) {
    for (int u = 2; u < kSide - 2; ++u) {
      const double from_axis = std::hypot(u - 59.5, v - 59.5),
                   from_hole = std::hypot(u - 60, v - 70);
      if (from_hole < 5.0) {
        EXPECT_FALSE(filled.view.has_sample(u, v)) << u << ' ' << v;
      }
      if (from_axis > 90.0 || from_hole < 11.0) continue;
      EXPECT_EQ(filled.view.has_sample(u, v), truth.has_sample(u, v)) << u << ' ' << v;
      if (filled.filled(u, v) && from_axis < 80.0) {
        EXPECT_NEAR(filled.view.range(u, v), truth.range(u, v), 0.05) << u << ' ' << v;
      }
    }
  }
}

TEST(FilledView, FillsWhatElseIsKnown) {
  RangeView view = ball(0.0);
  view.confidence = Grid<float>(kSide, kSide, 2.0f);
  view.deviation = Grid<float>(kSide, kSide, 0.5f);
  view.colours = Grid<Colour>(kSide, kSide, Colour{10, 20, 30});
  view.range(60, 60) = kNoSample;
  view.confidence(60, 60) = 0.0f;
  view.deviation(60, 60) = static_cast<float>(kNoSample);
  view.colours(60, 60) = {};
  const RangeView filled = fill_small_gaps(view).view;
  EXPECT_TRUE(filled.has_sample(60, 60));
  EXPECT_EQ(filled.confidence(60, 60), 2.0f);
  EXPECT_EQ(filled.deviation(60, 60), 0.5f);
  EXPECT_EQ(filled.colours(60, 60), (Colour{10, 20, 30}));
  // Its own normal was not lost.
  EXPECT_EQ(filled.normals(60, 60), view.normals(60, 60));
}

// Normals that turn along the rows as the cube of the column.
RangeView rippled() {
  RangeView view = ball(0.0);
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      const double x = 0.05 * (u - 60);
      view.normals(u, v) = Eigen::Vector3d(0.1 * x * x * x - 0.2 * x, 0.0, -1.0).cast<float>();
    }
  }
  return view;
}

TEST(FilledView, NormalsFollowACubicAcrossOneMissingSample) {
  const RangeView truth = rippled();
  RangeView view = truth;
  for (const int du : {-1, 0, 1}) {  // Nothing above nor below: the row alone tells.
    for (const int dv : {-1, 1}) view.range(60 + du, 60 + dv) = kNoSample;
  }
  view.range(60, 60) = kNoSample;
  view.normals(60, 60).setConstant(static_cast<float>(kNoSample));
  const RangeView filled = fill_small_gaps(view).view;
  ASSERT_TRUE(filled.has_normal(60, 60));
  const Eigen::Vector3f expected = truth.normals(60, 60).normalized();
  EXPECT_LT((filled.normals(60, 60) - expected).norm(), 1e-5);
}

TEST(FilledView, NormalsBeyondAStepTakeNoPart) {
  RangeView view = rippled();
  for (int v = 0; v < kSide; ++v) {
    for (int u = 62; u < kSide; ++u) {
      if (view.has_sample(u, v)) view.range(u, v) += 80.0;
      view.normals(u, v) = Eigen::Vector3f(0.6f, 0.0f, -0.8f);
    }
  }
  view.range(60, 60) = kNoSample;
  view.normals(60, 60).setConstant(static_cast<float>(kNoSample));
  const RangeView filled = fill_small_gaps(view).view;
  ASSERT_TRUE(filled.has_normal(60, 60));
  EXPECT_LT((filled.normals(60, 60) - rippled().normals(60, 60).normalized()).norm(), 0.01);
}

}  // namespace
}  // namespace relief
