// Filled regions that take another shape, and what must not come of it.

#include "fusion/holes/fair_fill.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>

#include <gtest/gtest.h>

#include "fusion/surface/isosurface.h"
#include "fusion/surface/vertex_attributes.h"
#include "fusion/tsdf/closed_field.h"
#include "fusion/tsdf/tsdf_integration.h"
#include "relief/fusion/merge_views.h"
#include "relief/scan/context.h"
#include "scan/mesh/mesh_components.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace relief::fusion {
namespace {

constexpr double kVoxel = 1.6, kTruncation = 4.8;

// What merging has before it moves filled vertices.
struct Merged {
  std::vector<ViewSampler> samplers;
  TriangleMesh mesh;
};

Merged merged(const std::vector<RangeView>& views, double voxel = kVoxel) {
  Merged result;
  for (const RangeView& view : views) {
    auto sampler = ViewSampler::create(view, {});
    if (sampler && !sampler->empty()) result.samplers.push_back(std::move(sampler).value());
  }
  ClosedFieldOptions options;
  options.voxel_size = voxel;
  options.truncation = kTruncation;
  const auto field = value_of(compute_closed_field(result.samplers, options, {}));
  result.mesh = extract_isosurface(field.finest());
  keep_largest_component(result.mesh);
  set_vertex_attributes(result.mesh, result.samplers,
                        {.truncation = kTruncation, .voxel_size = voxel, .view_stddev = 0.1});
  return result;
}

FairFillOptions default_options() {
  FairFillOptions options;
  options.truncation = kTruncation;
  options.voxel_size = kVoxel;
  return options;
}

// A sphere seen by some of the views around it.
std::vector<RangeView> sphere_from(int views, int of) {
  auto all = testing::views_around(testing::sphere(Eigen::Vector3d::Zero(), 50.0), of, 60, 50.0);
  all.resize(static_cast<std::size_t>(views));
  return all;
}

TEST(FairFill, WhereNothingIsFilledNothingMoves) {
  const Merged sphere = merged(sphere_from(14, 14));
  EXPECT_TRUE(fair_filled_regions(sphere.mesh, sphere.samplers, default_options())->places.empty());
}

TEST(FairFill, TooLargeRegionsStayAsTheyAre) {
  const Merged sphere = merged(sphere_from(3, 14));
  FairFillOptions options = default_options();
  options.most_solved = 0;
  const FairFill fair = fair_filled_regions(sphere.mesh, sphere.samplers, options).value();
  EXPECT_GT(fair.too_large, 0u);
  EXPECT_EQ(fair.unsolved, 0u);
  EXPECT_EQ(fair.places, sphere.mesh.vertices);
}

// A process that has nothing yet, and needs no more than these 20 MiB unless a plate is solved.
TEST(FairFill, OnlyRegionsThatAreSolvedNeedTheMemoryForIt) {
  const Merged sphere = merged(sphere_from(3, 14), 0.5 * kVoxel);
  MemoryLimit limit(std::size_t{20} << 20, {}, [] { return std::size_t{0}; });
  FairFillOptions options = default_options();
  options.voxel_size = 0.5 * kVoxel;
  options.memory = &limit;
  options.most_solved = 0;
  EXPECT_THAT(fair_filled_regions(sphere.mesh, sphere.samplers, options), IsOk());
  options.most_solved = FairFillOptions().most_solved;
  EXPECT_THAT(fair_filled_regions(sphere.mesh, sphere.samplers, options),
              HasError(ErrorKind::kUnsolvable, "limit of 20 MiB"));
}

TEST(FairFill, AsksWhetherToGoOn) {
  const Merged sphere = merged(sphere_from(3, 14));
  const FairFillOptions options = default_options();
  int asked = 0;
  const auto stop_at = [&](int most) {
    asked = 0;
    return fair_filled_regions(sphere.mesh, sphere.samplers, options,
                               [&asked, most](double, std::string_view) { return ++asked < most; });
  };
  ASSERT_THAT(stop_at(100000), IsOk());
  const int all = asked;
  ASSERT_GT(all, 3) << "in every round";
  for (const int most : {1, all / 2, all}) {
    EXPECT_THAT(stop_at(most), HasError(ErrorKind::kInterrupted)) << most;
    EXPECT_EQ(asked, most) << "nobody is asked again";
  }
}

// Of random scenes, where views contradict each other.
TEST(FairFill, NoFilledVertexComesFartherIntoSpaceSeenEmpty) {
  const testing::RandomScenes scenes;
  std::size_t moved = 0;
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    const Merged scene = merged(scenes.scene(seed));
    const auto places = fair_filled_regions(scene.mesh, scene.samplers, default_options())->places;
    TsdfIntegrator collector(scene.samplers, kTruncation, kVoxel);
    for (std::size_t v = 0; v < places.size(); ++v) {
      if (!scene.mesh.filled[v] || places[v] == scene.mesh.vertices[v]) continue;
      ++moved;
      EXPECT_LE(collector.collect(places[v]).clearance,
                std::max(0.25 * kVoxel, collector.collect(scene.mesh.vertices[v]).clearance))
          << "scene " << seed << ", vertex " << v;
    }
  }
  EXPECT_GT(moved, 1000u);
}

TEST(FairFill, TheRestOfTheSurfaceStaysWhereItIs) {
  const Merged sphere = merged(sphere_from(3, 14));
  const auto places = fair_filled_regions(sphere.mesh, sphere.samplers, default_options())->places;
  ASSERT_FALSE(places.empty());
  for (std::size_t v = 0; v < places.size(); ++v) {
    if (sphere.mesh.filled[v]) continue;
    EXPECT_LT((places[v] - sphere.mesh.vertices[v]).norm(), kVoxel);
  }
}

// A ball with a dish in it, seen from all around, without the samples near two points: the bottom
// of the dish, and the bottom of the ball.
TEST(FairFill, ANarrowValleyStaysAsTheClosedFieldHasIt) {
  const testing::SignedDistance shape = [](const Eigen::Vector3d& p) {
    return std::max(p.norm() - 50.0, 50.0 - (p - Eigen::Vector3d(0, 0, 70)).norm());
  };
  const Eigen::Vector3d valley(0, 0, 20), hill(0, 0, -50);
  auto views = testing::views_around(testing::traced(shape), 30, 60, 50.0);
  for (RangeView& view : views)
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        if (const Eigen::Vector3d p = view.world_from_view * view.point(u, v);
            (p - valley).norm() < 9.0 || (p - hill).norm() < 9.0)
          view.range(u, v) = kNoSample;
  const Merged ball = merged(views);
  const auto places = fair_filled_regions(ball.mesh, ball.samplers, default_options())->places;
  ASSERT_FALSE(places.empty());
  int in_valley = 0, on_hill = 0;
  for (std::size_t v = 0; v < places.size(); ++v) {
    const Eigen::Vector3d& before = ball.mesh.vertices[v];
    if (!ball.mesh.filled[v]) continue;
    if ((before - valley).norm() < 6.0) {
      ++in_valley;
      EXPECT_EQ(places[v], before);
    } else if ((before - hill).norm() < 6.0) {
      ++on_hill;
      EXPECT_LT(std::abs(shape(places[v])), std::abs(shape(before))) << "closer than the membrane";
    }
  }
  EXPECT_GT(in_valley, 20);
  EXPECT_GT(on_hill, 20);
}

// The walls of a block that nobody saw from below.
TEST(FairFill, WallsKeepTheirEndsWhereALidBegins) {
  auto views = testing::views_around(testing::traced(testing::box_distance({30.0, 30.0, 30.0})), 30,
                                     60, 52.0);
  std::erase_if(views, [](const RangeView& view) {
    return view.world_from_view.translation().normalized().z() < -0.2;
  });
  const Merged block = merged(views);
  const auto places = fair_filled_regions(block.mesh, block.samplers, default_options())->places;
  ASSERT_FALSE(places.empty());
  std::vector<std::uint8_t> beside(places.size(), 0);
  for (const auto& face : block.mesh.faces)
    if (std::any_of(face.begin(), face.end(), [&](auto v) { return !block.mesh.filled[v]; }))
      for (const std::uint32_t v : face) beside[v] = block.mesh.filled[v];
  int ends = 0;
  double mean = 0.0;
  for (std::size_t v = 0; v < places.size(); ++v) {
    const Eigen::Vector3d& before = block.mesh.vertices[v];
    if (!beside[v] || before.z() > -25.0) continue;
    ++ends;
    mean += (places[v] - before).norm();
  }
  EXPECT_GT(ends, 50);
  EXPECT_LT(mean / ends, 0.1 * kVoxel);
}

std::size_t scarce() { return std::size_t{90} << 20; }

TEST(FairFill, ThreadsAndALimitOfMemoryDoNotChangeAByte) {
  const Merged sphere = merged(sphere_from(3, 14));
  PagedVector<Eigen::Vector3d> reference;
  for (const int threads : testing::compared_threads({1, 2, 4})) {
    const auto places = on_threads(threads, [&] {
      return fair_filled_regions(sphere.mesh, sphere.samplers, default_options())->places;
    });
    if (reference.empty()) reference = places;
    ASSERT_FALSE(places.empty());
    EXPECT_EQ(places, reference);
  }
  FairFillOptions options = default_options();
  MemoryLimit wide(std::size_t{1000} << 20, {}, scarce);
  options.memory = &wide;
  EXPECT_EQ(value_of(fair_filled_regions(sphere.mesh, sphere.samplers, options)).places, reference);
  MemoryLimit tight(std::size_t{94} << 20, {}, scarce);
  options.memory = &tight;
  EXPECT_THAT(fair_filled_regions(sphere.mesh, sphere.samplers, options),
              HasError(ErrorKind::kUnsolvable, "limit of 94 MiB"))
      << "the factor does not fit into 4 MiB";
}

}  // namespace
}  // namespace relief::fusion
