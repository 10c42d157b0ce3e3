#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "fusion/surface/isosurface.h"
#include "fusion/surface/vertex_attributes.h"
#include "fusion/tsdf/closed_field.h"
#include "relief/fusion/merge_views.h"
#include "relief/scan/context.h"
#include "scan/base/memory/memory_limit.h"
#include "scan/base/system/system_memory.h"
#include "tests/fusion/scenes.h"
#include "tests/support/memory_limits.h"
#include "tests/support/result_matchers.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace relief::fusion {
namespace {

using testing::always_near_the_limit;
using testing::kMebibyte;

class MergeWithinLimit : public ::testing::Test {
 protected:
  const testing::TemporaryFolder folder_;
};

bool same(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices == b.vertices && a.faces == b.faces && a.normals == b.normals &&
         a.quality == b.quality && a.views == b.views && a.filled == b.filled;
}

std::vector<RangeView> scene() {
  auto views =
      testing::views_around(testing::traced(testing::torus_distance(35.0, 12.0)), 10, 90, 50.0);
  for (std::size_t i = 0; i < views.size(); ++i)
    testing::add_range_noise(views[i], 0.2, static_cast<std::uint32_t>(i));
  return views;
}

// Every brick starts with nothing resident.
TriangleMesh surface_of_scene(const std::vector<RangeView>& views, MemoryLimit* memory) {
  std::vector<ViewSampler> samplers;
  for (const RangeView& view : views) {
    PagedSurfaceOptions options;
    options.memory = memory;
    samplers.push_back(ViewSampler::create(view, options).value());
  }
  ClosedFieldOptions options;
  options.voxel_size = 1.2;
  options.truncation = 3.6;
  options.memory = memory;
  const auto field = value_of(compute_closed_field(samplers, options, {}));
  TriangleMesh mesh = extract_isosurface(field.finest(), memory);
  set_vertex_attributes(
      mesh, samplers, {.truncation = 3.6, .voxel_size = 1.2, .view_stddev = 0.2, .memory = memory});
  return mesh;
}

TEST_F(MergeWithinLimit, BrickByBrickTheModelIsTheSameToTheByte) {
  const auto views = scene();
  const TriangleMesh in_memory = surface_of_scene(views, nullptr);
  EXPECT_GT(in_memory.vertices.size(), 10000u);
  for (const int threads : {1, 3}) {
    MemoryLimit limit(100 * kMebibyte, folder_.path(), always_near_the_limit);
    EXPECT_TRUE(
        same(on_threads(threads, [&] { return surface_of_scene(views, &limit); }), in_memory));
    EXPECT_GT(limit.releases(), 100u);
  }
}

TEST_F(MergeWithinLimit, MergingGivesTheSameWithinAnyLimitThatItCanKeep) {
  if (testing::sanitized()) GTEST_SKIP() << "sanitizers keep memory that was freed";
  const auto views = scene();
  const auto free = value_of(merge_views(views));
  for (const std::size_t room : {40, 400}) {
    const auto limited = value_of(merge_views(
        views, {},
        {.memory = resident_memory() + room * kMebibyte, .temporary_folder = folder_.path()}));
    EXPECT_TRUE(same(limited.mesh, free.mesh));
  }
  EXPECT_EQ(folder_.size(), 0u);
}

TEST_F(MergeWithinLimit, ALimitThatCannotBeKeptIsAnErrorThatSaysWhatIsNeeded) {
  EXPECT_THAT(merge_views(scene(), {}, {.memory = kMebibyte, .temporary_folder = folder_.path()}),
              HasError(ErrorKind::kUnsolvable, "limit of 1 MiB"));
}

TEST_F(MergeWithinLimit, AViewThatCannotBeLoadedEndsTheMerging) {
  const auto views = scene();
  const ViewSource source{views.size(),
                          [&](std::size_t i) -> Result<std::shared_ptr<const RangeView>> {
                            if (i == 3) return Error{ErrorKind::kBadInput, "view 3 is gone"};
                            return std::make_shared<const RangeView>(views[i]);
                          }};
  const auto merged = merge_from_source(source);
  ASSERT_THAT(merged, HasError());
  EXPECT_EQ(merged.error().message, "view 3 is gone");
}

}  // namespace
}  // namespace relief::fusion
