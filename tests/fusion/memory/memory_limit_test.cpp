#include "fusion/memory/memory_limit.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "fusion/memory/paged_array.h"
#include "fusion/surface/isosurface.h"
#include "fusion/surface/vertex_attributes.h"
#include "fusion/tsdf/closed_field.h"
#include "relief/fusion/merge_views.h"
#include "relief/scan/context.h"
#include "scan/base/system/system_memory.h"
#include "tests/fusion/scenes.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief::fusion {
namespace {

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

std::size_t entries_of(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

class MemoryLimitTest : public ::testing::Test {
 protected:
  const testing::TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

// relieve() asks three times: before and after it takes the lock, and when pages were handed back.
// Every call finds the process near a limit of 100 MiB, and then far below it.
std::size_t always_near_the_limit() {
  thread_local std::size_t questions = 0;
  return questions++ % 3 == 2 ? kMebibyte : 99 * kMebibyte;
}

TEST_F(MemoryLimitTest, ArraysKeepTheirValuesWhenTheirPagesAreHandedBack) {
  MemoryLimit limit(100 * kMebibyte, folder_, always_near_the_limit);
  PagedArray<std::uint32_t> array(1 << 22, &limit);  // 16 MiB: more than an eighth of the limit.
  for (std::uint32_t i = 0; i < array.size(); ++i) {
    ASSERT_EQ(array[i], 0u);
    array[i] = 2654435761u * i;
  }
  EXPECT_EQ(limit.releases(), 0u);
  limit.evict_pages();
  EXPECT_EQ(limit.releases(), 1u);
  const PagedArray<std::uint32_t> moved = std::move(array);
  for (std::uint32_t i = 0; i < moved.size(); ++i) ASSERT_EQ(moved[i], 2654435761u * i);
  EXPECT_THAT(limit.check(), IsOk());
  EXPECT_EQ(entries_of(folder_), 0u) << "the files have no name";
}

TEST_F(MemoryLimitTest, AnEighthOfTheLimitMayLieInMemory) {
  MemoryLimit limit(800 * kMebibyte, folder_, [] { return 40 * kMebibyte; });
  EXPECT_FALSE(limit.keep_in_memory(61 * kMebibyte)) << "the process has 40 of 100 MiB";
  EXPECT_TRUE(limit.keep_in_memory(50 * kMebibyte));
  EXPECT_TRUE(limit.keep_in_memory(10 * kMebibyte));
  EXPECT_FALSE(limit.keep_in_memory(1));
}

TEST_F(MemoryLimitTest, PagesHandedBackAreNoLongerResident) {
  MemoryLimit limit(1, folder_);
  PagedArray<std::uint8_t> array(64 * kMebibyte, &limit);
  std::fill(array.begin(), array.end(), std::uint8_t{7});
  const std::size_t before = resident_memory();
  limit.evict_pages();
  EXPECT_LT(resident_memory() + 48 * kMebibyte, before);
  EXPECT_EQ(array[array.size() / 2], 7);
  EXPECT_THAT(limit.check(), HasError(ErrorKind::kUnsolvable, "are needed"))
      << "no process fits into one byte";
}

TEST_F(MemoryLimitTest, AFolderThatCannotHoldFilesIsAnErrorAndTheArrayStillWorks) {
  MemoryLimit limit(100 * kMebibyte, folder_ / "absent");
  PagedArray<int> array(1000, &limit);
  array[999] = 3;
  EXPECT_EQ(array[999], 3);
  EXPECT_THAT(limit.check(), HasError(ErrorKind::kCannotWrite, "absent"));
}

TEST_F(MemoryLimitTest, AFileLargerThanTheDiskIsAnError) {
  MemoryLimit limit(100 * kMebibyte, folder_);
  EXPECT_EQ(limit.map(std::size_t{1} << 60), nullptr);
  EXPECT_THAT(limit.check(), HasError());
}

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

TEST_F(MemoryLimitTest, BrickByBrickTheModelIsTheSameToTheByte) {
  const auto views = scene();
  const TriangleMesh in_memory = surface_of_scene(views, nullptr);
  EXPECT_GT(in_memory.vertices.size(), 10000u);
  for (const int threads : {1, 3}) {
    MemoryLimit limit(100 * kMebibyte, folder_, always_near_the_limit);
    EXPECT_TRUE(
        same(on_threads(threads, [&] { return surface_of_scene(views, &limit); }), in_memory));
    EXPECT_GT(limit.releases(), 100u);
  }
}

TEST_F(MemoryLimitTest, MergingGivesTheSameWithinAnyLimitThatItCanKeep) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers keep memory that was freed";
#endif
  const auto views = scene();
  const auto free = value_of(merge_views(views));
  for (const std::size_t room : {40, 400}) {
    const auto limited = value_of(merge_views(
        views, {}, {.memory = resident_memory() + room * kMebibyte, .temporary_folder = folder_}));
    EXPECT_TRUE(same(limited.mesh, free.mesh));
  }
  EXPECT_EQ(entries_of(folder_), 0u);
}

TEST_F(MemoryLimitTest, ALimitThatCannotBeKeptIsAnErrorThatSaysWhatIsNeeded) {
  EXPECT_THAT(merge_views(scene(), {}, {.memory = kMebibyte, .temporary_folder = folder_}),
              HasError(ErrorKind::kUnsolvable, "limit of 1 MiB"));
}

TEST_F(MemoryLimitTest, AViewThatCannotBeLoadedEndsTheMerging) {
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
