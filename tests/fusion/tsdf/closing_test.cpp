// What merging puts where nobody measured: closed, smooth, out of space seen empty, and marked.

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "relief/fusion/merge_views.h"
#include "relief/scan/discontinuities.h"
#include "scan/grid/connected_grid.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"

namespace relief::fusion {
namespace {

using testing::SignedDistance;

constexpr double kRadius = 50.0;

// Filled vertices that lie more than half a voxel in front of what some view measured, by
// projection into every view, where its samples hang together all around. Beside an occlusion edge
// as beside a gap nobody knows where between two rays the nearer surface ends.
std::size_t vertices_in_empty_space(const MergeResult& merged,
                                    const std::vector<RangeView>& views) {
  std::vector<Grid<std::uint8_t>> to_boundary;
  for (const RangeView& view : views)
    to_boundary.push_back(boundary_distance(view, connect_samples(view)));
  std::size_t count = 0;
  for (std::size_t v = 0; v < merged.mesh.vertices.size(); ++v) {
    if (!merged.mesh.filled[v]) continue;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const RangeView& view = views[i];
      const Eigen::Vector3d p = view.world_from_view.inverse() * merged.mesh.vertices[v];
      const auto pixel = view.camera.project(p);
      if (!pixel) continue;
      const int u = static_cast<int>(std::lround(pixel->x()));
      const int w = static_cast<int>(std::lround(pixel->y()));
      if (!to_boundary[i].contains(u, w) || to_boundary[i](u, w) == 0) continue;
      const double in_front = view.normals(u, w).cast<double>().dot(p - view.point(u, w));
      if (in_front <= 0.5 * merged.voxel_size) continue;
      ++count;
      break;
    }
  }
  return count;
}

// The part of the vertices whose `filled` is as `expected` says, of those about which it says
// anything.
double rightly_filled(const MergeResult& merged,
                      const std::function<std::optional<bool>(const Eigen::Vector3d&)>& expected) {
  double right = 0.0, all = 0.0;
  for (std::size_t v = 0; v < merged.mesh.vertices.size(); ++v) {
    const auto filled = expected(merged.mesh.vertices[v]);
    if (!filled) continue;
    right += (merged.mesh.filled[v] != 0) == *filled;
    all += 1.0;
  }
  return right / all;
}

// Median angle between the normals at the ends of the edges of filled faces [rad].
double roughness(const TriangleMesh& mesh) {
  std::vector<double> angles;
  for (const auto& face : mesh.faces) {
    if (!mesh.filled[face[0]] || !mesh.filled[face[1]] || !mesh.filled[face[2]]) continue;
    const double cosine =
        mesh.normals[face[0]].cast<double>().dot(mesh.normals[face[1]].cast<double>());
    angles.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)));
  }
  if (angles.empty()) return 0.0;
  std::nth_element(angles.begin(), angles.begin() + static_cast<long>(angles.size() / 2),
                   angles.end());
  return angles[angles.size() / 2];
}

MergeResult closed(const std::vector<RangeView>& views, const MergeOptions& options = {}) {
  auto merged = value_of(merge_views(views, options));
  EXPECT_EQ(merged.check.components, 1u);
  EXPECT_EQ(vertices_in_empty_space(merged, views), 0u);
  return merged;
}

std::vector<RangeView> from_above(const SignedDistance& shape, int count, int size,
                                  double least_z) {
  std::vector<RangeView> views;
  for (RangeView& view : testing::views_around(testing::traced(shape), count, size, kRadius))
    if (view.world_from_view.translation().normalized().z() > least_z)
      views.push_back(std::move(view));
  return views;
}

TEST(Closing, ASphereSeenFromOneSideGetsASmoothBack) {
  const auto views = from_above(testing::sphere_distance(kRadius), 14, 80, 0.6);
  ASSERT_GE(views.size(), 2u);
  const MergeResult merged = closed(views);
  EXPECT_TRUE(merged.check.watertight());
  EXPECT_EQ(merged.check.genus, 0);
  EXPECT_GT(merged.filled_area_fraction, 0.15);
  EXPECT_LT(roughness(merged.mesh), 0.1);
  const auto expected = [&](const Eigen::Vector3d& p) -> std::optional<bool> {
    if (std::abs(p.norm() - kRadius) > 0.5 * merged.voxel_size) return true;
    double best = -1.0;
    for (const RangeView& view : views)
      best =
          std::max(best, p.normalized().dot((view.world_from_view.translation() - p).normalized()));
    if (best > 0.1 && best < 0.3) return std::nullopt;  // some grazing samples make quads
    return best < 0.2;
  };
  EXPECT_GT(rightly_filled(merged, expected), 0.99);
}

TEST(Closing, ABlockNeverSeenFromBelowGetsAPlainBase) {
  const SignedDistance block = testing::box_distance({30.0, 25.0, 20.0});
  const auto views = from_above(block, 20, 80, 0.05);
  const MergeResult merged = closed(views);
  EXPECT_TRUE(merged.check.watertight());
  EXPECT_EQ(merged.check.genus, 0);
  // Views see the walls down to 1.4 above the base. It closes there, but for a corner or two.
  double lowest = 0.0, deepest = 0.0, highest = -100.0;
  for (std::size_t v = 0; v < merged.mesh.vertices.size(); ++v) {
    const Eigen::Vector3d& p = merged.mesh.vertices[v];
    lowest = std::min(lowest, p.z());
    if (!merged.mesh.filled[v] || std::abs(p.x()) > 25.0 || std::abs(p.y()) > 20.0) continue;
    highest = std::max(highest, p.z());
    deepest = std::min(deepest, p.z());
  }
  EXPECT_GT(lowest, -22.0);
  EXPECT_GT(deepest, -20.5) << "the base is plane";
  EXPECT_LT(highest, -18.0);
  EXPECT_LT(roughness(merged.mesh), 0.1);
  const auto expected = [](const Eigen::Vector3d& p) -> std::optional<bool> {
    if (p.z() > -18.0) return false;
    return p.z() < -19.3 || (std::abs(p.x()) < 28.0 && std::abs(p.y()) < 23.0) ? std::optional(true)
                                                                               : std::nullopt;
  };
  EXPECT_GT(rightly_filled(merged, expected), 0.99) << "but for the rim of the base";
}

// Takes samples away from all views.
void lose(std::vector<RangeView>& views, const std::function<bool(const Eigen::Vector3d&)>& lost) {
  for (RangeView& view : views)
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        if (view.has_sample(u, v) && lost(view.world_from_view * view.point(u, v)))
          view.range(u, v) = kNoSample;
}

// One view sees less than half of a sphere. The membrane behind it would be off by a radius.
TEST(Closing, ASphereSeenByOneViewGoesOnAsASphere) {
  auto views = from_above(testing::sphere_distance(kRadius), 14, 100, 0.6);
  views.resize(1);
  const MergeResult merged = closed(views);
  EXPECT_TRUE(merged.check.watertight());
  EXPECT_EQ(merged.check.genus, 0);
  double squares = 0.0, farthest = 0.0;
  for (const Eigen::Vector3d& p : merged.mesh.vertices) {
    const double off = std::abs(p.norm() - kRadius);
    squares += off * off;
    farthest = std::max(farthest, off);
  }
  const double rms = std::sqrt(squares / static_cast<double>(merged.mesh.vertices.size()));
  EXPECT_LT(rms, 0.1 * kRadius);
  EXPECT_LT(farthest, 0.2 * kRadius);
}

// A tenth of a sphere masked in all views.
std::vector<RangeView> views_with_hole(int size) {
  auto views =
      testing::views_around(testing::sphere(Eigen::Vector3d::Zero(), kRadius), 12, size, kRadius);
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();
  lose(views, [&](const Eigen::Vector3d& p) { return p.normalized().dot(axis) > 0.8; });
  return views;
}

TEST(Closing, AHoleOfATenthOfTheSurfaceIsSpannedAndMarked) {
  const auto views = views_with_hole(120);
  const MergeResult merged = closed(views);
  EXPECT_TRUE(merged.check.watertight());
  EXPECT_EQ(merged.check.genus, 0);
  EXPECT_NEAR(merged.filled_area_fraction, 0.09, 0.03);
  EXPECT_LT(roughness(merged.mesh), 0.05);
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();
  const double share = rightly_filled(
      merged, [&](const Eigen::Vector3d& p) { return p.normalized().dot(axis) > 0.8; });
  EXPECT_GT(share, 0.99);
  double deepest = 0.0;
  for (const Eigen::Vector3d& p : merged.mesh.vertices)
    deepest = std::max(deepest, std::abs(p.norm() - kRadius));
  EXPECT_LT(deepest, 1.6) << "the sphere goes on; a flat lid would be 10 deep";
}

// A disc of half the thickness `half` round the z axis.
SignedDistance disc(double radius, double centre, double half) {
  return [=](const Eigen::Vector3d& p) {
    const Eigen::Vector2d beyond(p.head<2>().norm() - radius, std::abs(p.z() - centre) - half);
    return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
  };
}

// A boss on a disc: light that goes to and fro between the two spoils the samples beside the edge
// where they meet, in all views.
TEST(Closing, ACreaseLostToInterreflectionIsRoundedOffAndMarked) {
  constexpr double kTop = -8.0, kBoss = 16.0, kLost = 6.0;
  const SignedDistance base = disc(38.0, kTop - 6.0, 6.0), boss = disc(kBoss, kTop + 8.0, 14.0);
  const SignedDistance shape = [=](const Eigen::Vector3d& p) { return std::min(base(p), boss(p)); };
  const auto from_crease = [](const Eigen::Vector3d& p) {
    return std::hypot(p.head<2>().norm() - kBoss, p.z() - kTop);
  };
  auto views = testing::views_around(testing::traced(shape), 20, 110, kRadius);
  lose(views, [&](const Eigen::Vector3d& p) { return from_crease(p) < kLost; });

  const MergeResult merged = closed(views);
  EXPECT_TRUE(merged.check.watertight());
  EXPECT_EQ(merged.check.genus, 0);
  EXPECT_LT(roughness(merged.mesh), 0.1);
  double least = kLost, lowest = 0.0;
  for (std::size_t v = 0; v < merged.mesh.vertices.size(); ++v) {
    if (!merged.mesh.filled[v]) continue;
    least = std::min(least, from_crease(merged.mesh.vertices[v]));
    lowest = std::min(lowest, shape(merged.mesh.vertices[v]));
  }
  EXPECT_GT(least, 1.0) << "a fillet";
  EXPECT_GT(lowest, -0.5 * merged.voxel_size) << "that cuts into nothing";
  const double share = rightly_filled(merged, [&](const Eigen::Vector3d& p) -> std::optional<bool> {
    if (std::abs(from_crease(p) - kLost) < 0.5 * merged.voxel_size) return std::nullopt;
    return from_crease(p) < kLost;
  });
  EXPECT_GT(share, 0.99);
}

// A step across a block, open at both ends: the gap along its crease ends in free space. Twelve
// views see some corners at grazing angles only.
TEST(Closing, ACreaseOpenAtItsEndsLeavesSpaceSeenEmptyAlone) {
  constexpr double kTop = -5.0, kLost = 6.0;
  const SignedDistance low = testing::box_distance({30.0, 25.0, 15.0});
  const SignedDistance high = testing::box_distance({15.0, 25.0, 15.0});
  const SignedDistance shape = [=](const Eigen::Vector3d& p) {
    return std::min(low(p + Eigen::Vector3d(0.0, 0.0, 15.0 - kTop)),
                    high(p - Eigen::Vector3d(-15.0, 0.0, kTop)));
  };
  auto views = testing::views_around(testing::traced(shape), 12, 80, kRadius);
  lose(views, [&](const Eigen::Vector3d& p) { return std::hypot(p.x(), p.z() - kTop) < kLost; });
  const MergeResult merged = closed(views);
  EXPECT_TRUE(merged.check.watertight());
  EXPECT_EQ(merged.check.genus, 0);
}

// A sphere with waves of height 2.
SignedDistance wavy_sphere() {
  return [](const Eigen::Vector3d& p) {
    const Eigen::Vector3d wave = (0.25 * p).array().sin();
    return (p.norm() - kRadius - 2.0 * wave.x() * wave.y() * wave.z()) / 1.5;
  };
}

// RMS error of the filled vertices where a dark patch returned some of its samples.
double error_in_dark_patch(double returned) {
  const SignedDistance shape = wavy_sphere();
  auto views = testing::views_around(testing::traced(shape), 12, 120, 1.05 * kRadius);
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();
  std::mt19937 random(1);
  lose(views, [&](const Eigen::Vector3d& p) {
    return p.normalized().dot(axis) > 0.9 &&
           std::uniform_real_distribution<double>(0.0, 1.0)(random) > returned;
  });
  // Single samples are no surface that the model must not stand out of.
  const MergeResult merged = value_of(merge_views(views));
  EXPECT_TRUE(merged.check.watertight());
  EXPECT_EQ(merged.check.components, 1u);
  EXPECT_EQ(merged.check.genus, 0);
  double squares = 0.0, filled = 0.0;
  for (std::size_t v = 0; v < merged.mesh.vertices.size(); ++v) {
    if (!merged.mesh.filled[v]) continue;
    squares += std::pow(1.5 * shape(merged.mesh.vertices[v]), 2);
    filled += 1.0;
  }
  EXPECT_GT(filled, 500.0);
  return std::sqrt(squares / filled);
}

// Most of them are single: none of them is a surface, and yet they tell where it is.
TEST(Closing, ADarkPatchFollowsTheSamplesThatItReturned) {
  const double none = error_in_dark_patch(0.0), some = error_in_dark_patch(0.2);
  EXPECT_GT(none, 0.8) << "nobody knows of the waves";
  EXPECT_LT(some, 0.3 * none);
}

TEST(Closing, OnlySmallHolesAreFilledOnRequest) {
  auto views = views_with_hole(80);
  // A hole of ten pixels besides: near the pole away from the large one.
  const Eigen::Vector3d spot = -Eigen::Vector3d(1, 2, 3).normalized();
  lose(views, [&](const Eigen::Vector3d& p) { return (p - kRadius * spot).norm() < 7.0; });
  MergeOptions options;
  options.largest_fill = 10.0;
  const MergeResult merged = closed(views, options);
  EXPECT_GT(merged.check.boundary_edges, 0u);
  EXPECT_EQ(merged.check.non_manifold_edges, 0u);
  std::size_t filled = 0;
  for (std::size_t v = 0; v < merged.mesh.vertices.size(); ++v) {
    if (!merged.mesh.filled[v]) continue;
    ++filled;
    EXPECT_LT((merged.mesh.vertices[v] - kRadius * spot).norm(), 11.0);
  }
  EXPECT_GT(filled, 5u) << "the small hole is filled";
  options.largest_fill = 1000.0;
  EXPECT_TRUE(closed(views, options).check.watertight());
}

}  // namespace
}  // namespace relief::fusion
