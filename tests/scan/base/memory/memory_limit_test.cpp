#include "scan/base/memory/memory_limit.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "relief/scan/grid.h"
#include "scan/base/memory/paged_array.h"
#include "scan/base/memory/paged_lists.h"
#include "scan/base/parallel.h"
#include "scan/base/system/system_memory.h"
#include "tests/support/memory_limits.h"
#include "tests/support/result_matchers.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::always_near_the_limit;
using testing::kMebibyte;

class MemoryLimitTest : public ::testing::Test {
 protected:
  const testing::TemporaryFolder folder_;
};

TEST_F(MemoryLimitTest, ArraysKeepTheirValuesWhenTheirPagesAreHandedBack) {
  MemoryLimit limit(100 * kMebibyte, folder_.path(), always_near_the_limit);
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
  EXPECT_EQ(folder_.size(), 0u) << "the files have no name";
}

TEST_F(MemoryLimitTest, ManyShortListsLieInFewFiles) {
  const Context context{.memory = 64 * kMebibyte, .temporary_folder = folder_.path()};
  PagedLists<std::uint64_t> lists;
  ASSERT_TRUE(run_until_stopped(context, [&] {
    const std::size_t before = resident_beyond_files();
    for (std::uint64_t i = 0; i < 100'000; ++i)
      lists.add(std::vector<std::uint64_t>(i % 1000, i));  // 400 MB in all.
    EXPECT_LT(resident_beyond_files(), before + 24 * kMebibyte);
  }));
  ASSERT_EQ(lists.size(), 100'000u);
  for (std::uint64_t i = 0; i < lists.size(); ++i) {
    ASSERT_EQ(lists[i].size(), i % 1000);
    if (!lists[i].empty()) {
      ASSERT_EQ(lists[i].front(), i);
      ASSERT_EQ(lists[i].back(), i);
    }
  }
}

// As the masks of a thousand small views, which came to as much as all else.
TEST_F(MemoryLimitTest, ManySmallGridsLieInFewFiles) {
  const Context context{.memory = 64 * kMebibyte, .temporary_folder = folder_.path()};
  ASSERT_TRUE(run_until_stopped(context, [&] {
    const std::size_t before = resident_beyond_files();
    std::vector<Grid<std::uint8_t>> grids;
    for (int round = 0; round < 2; ++round) {
      grids.clear();
      for (int i = 0; i < 4000; ++i) grids.emplace_back(100 + i % 500, 100, std::uint8_t(i));
      EXPECT_LT(resident_beyond_files(), before + 24 * kMebibyte) << "of 140 MB";
    }
    for (int i = 0; i < 4000; ++i)
      for (const std::uint8_t value : grids[static_cast<std::size_t>(i)])
        ASSERT_EQ(value, std::uint8_t(i));
  }));
}

TEST_F(MemoryLimitTest, ShortArraysAreZeroAlsoWhereOthersWere) {
  MemoryLimit limit(1, folder_.path());
  for (int round = 0; round < 3; ++round) {
    std::vector<PagedArray<std::uint32_t>> arrays;
    for (std::size_t i = 0; i < 300; ++i) arrays.emplace_back(1024 + 57 * i, &limit);
    for (auto& array : arrays) {
      for (const std::uint32_t value : array) ASSERT_EQ(value, 0u);
      std::fill(array.begin(), array.end(), 0xffffffffU);
    }
  }
}

TEST_F(MemoryLimitTest, AnEighthOfTheLimitMayLieInMemory) {
  MemoryLimit limit(800 * kMebibyte, folder_.path(), [] { return 40 * kMebibyte; });
  EXPECT_FALSE(limit.keep_in_memory(61 * kMebibyte)) << "the process has 40 of 100 MiB";
  EXPECT_TRUE(limit.keep_in_memory(50 * kMebibyte));
  EXPECT_TRUE(limit.keep_in_memory(10 * kMebibyte));
  EXPECT_FALSE(limit.keep_in_memory(1));
}

TEST_F(MemoryLimitTest, ArraysThatEndLeaveTheirRoomToOthers) {
  MemoryLimit limit(800 * kMebibyte, folder_.path(), [] { return kMebibyte; });
  for (int round = 0; round < 3; ++round) PagedArray<std::uint8_t> array(80 * kMebibyte, &limit);
  EXPECT_TRUE(limit.keep_in_memory(80 * kMebibyte));
}

// As of a tree that a function within a limit returned.
TEST_F(MemoryLimitTest, ArraysMayOutliveTheLimitTheyWereMadeUnder) {
  PagedArray<std::uint32_t> array;
  run_until_stopped({.memory = 1, .temporary_folder = folder_.path()},
                    [&] { array = PagedArray<std::uint32_t>(100000); });
  array[99999] = 7;
  EXPECT_EQ(array[99999], 7u);
}

TEST_F(MemoryLimitTest, PagesHandedBackAreNoLongerResident) {
  MemoryLimit limit(1, folder_.path());
  PagedArray<std::uint8_t> array(64 * kMebibyte, &limit);
  std::fill(array.begin(), array.end(), std::uint8_t{7});
  const std::size_t before = resident_memory();
  limit.evict_pages();
  EXPECT_LT(resident_memory() + 48 * kMebibyte, before);
  EXPECT_EQ(array[array.size() / 2], 7);
  EXPECT_THAT(limit.check(), HasError(ErrorKind::kUnsolvable, "are needed"))
      << "no process fits into one byte";
}

TEST_F(MemoryLimitTest, PagesThatOtherThreadsFetchMeanwhileDoNotEndTheWork) {
  std::atomic<int> looks = 0;
  MemoryLimit limit(100 * kMebibyte, folder_.path(),
                    [&] { return ++looks < 8 ? 200 * kMebibyte : 50 * kMebibyte; });
  limit.evict_pages();
  EXPECT_THAT(limit.check(), IsOk());
  EXPECT_GT(limit.releases(), 1u);
}

TEST_F(MemoryLimitTest, AFolderThatCannotHoldFilesIsAnErrorAndTheArrayStillWorks) {
  MemoryLimit limit(kMebibyte, folder_ / "absent");
  PagedArray<int> array(10000, &limit);
  array[9999] = 3;
  EXPECT_EQ(array[9999], 3);
  EXPECT_THAT(limit.check(), HasError(ErrorKind::kCannotWrite, "absent"));
}

TEST_F(MemoryLimitTest, AFileLargerThanTheDiskIsAnError) {
  MemoryLimit limit(100 * kMebibyte, folder_.path());
  EXPECT_EQ(limit.map(std::size_t{1} << 60), nullptr);
  EXPECT_THAT(limit.check(), HasError());
}

Grid<std::uint32_t> numbered(int width, int height) {
  Grid<std::uint32_t> grid(width, height);
  std::iota(grid.begin(), grid.end(), 7u);
  return grid;
}

// Grids of 100 MiB, made and read under a limit that has room for half of them.
TEST_F(MemoryLimitTest, GridsKeepTheirValuesWithinALimitThatHasNoRoomForThem) {
  if (testing::sanitized()) GTEST_SKIP() << "sanitizers keep memory that was freed";
  const std::size_t limit = resident_memory() + 50 * kMebibyte;
  std::atomic<std::size_t> most{0};
  const auto look = [&] {
    for (std::size_t now = resident_memory(), seen = most; now > seen;)
      if (most.compare_exchange_weak(seen, now)) break;
  };
  const Context context{.threads = 2, .memory = limit, .temporary_folder = folder_.path()};
  std::vector<Grid<std::uint32_t>> grids(100);
  const bool done = run_until_stopped(context, [&] {
    for (int round = 0; round < 2; ++round)
      parallel_for(grids.size(), 1, [&](std::size_t begin, std::size_t) {
        if (round == 0) grids[begin] = numbered(512, 512);
        EXPECT_EQ(grids[begin](511, 511), 7u + 512 * 512 - 1);
        look();
      });
  });
  EXPECT_TRUE(done);
  EXPECT_LT(most, limit);
  EXPECT_EQ(folder_.size(), 0u) << "the files have no name";
  for (const auto& grid : grids) EXPECT_EQ(grid(17, 3), 7u + 3 * 512 + 17) << "after the limit";
}

// Loops over scattered pages, as those of patches of a large mesh, bring many between two looks.
TEST_F(MemoryLimitTest, LoopsThatDoNotLookAtTheMemoryKeepTheLimitToo) {
  if (testing::sanitized()) GTEST_SKIP() << "sanitizers have much memory of their own";
  constexpr std::size_t kFile = 400 * kMebibyte, kPage = 4096, kPages = kFile / kPage;
  const std::size_t limit = resident_memory() + 100 * kMebibyte;
  // The thread that evicts may have to wait for a busy machine.
  const auto comes_within_limit = [&] {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (resident_memory() > limit && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return resident_memory() <= limit;
  };
  run_until_stopped({.memory = limit, .temporary_folder = folder_.path()}, [&] {
    PagedArray<std::uint8_t> array(kFile, current_memory_limit());
    for (std::uint8_t round = 0; round < 3; ++round)
      for (std::size_t i = 0; i < kPages; ++i) {
        std::uint8_t& byte = array[i * 2654435761u % kPages * kPage];
        ASSERT_EQ(byte, round);
        ++byte;
        if (i % 8192 == 0) {
          ASSERT_TRUE(comes_within_limit());
        }
      }
    EXPECT_GT(current_memory_limit()->releases(), 0u);
  });
}

TEST_F(MemoryLimitTest, CopiesOfGridsOutsideOfALimitLieInMemory) {
  std::optional<Grid<std::uint32_t>> inside;
  run_until_stopped({.memory = 1, .temporary_folder = folder_.path()},
                    [&] { inside = numbered(300, 300); });
  const Grid<std::uint32_t> copy = *inside;
  inside.reset();
  EXPECT_EQ(copy(299, 299), 7u + 300 * 300 - 1);
  EXPECT_EQ(current_memory_limit(), nullptr);
}

TEST_F(MemoryLimitTest, TheOuterLimitHoldsInside) {
  run_until_stopped({.memory = 900 * kMebibyte, .temporary_folder = folder_.path()}, [&] {
    const MemoryLimit* const outer = current_memory_limit();
    run_until_stopped({.memory = 5 * kMebibyte}, [&] {
      parallel_for(2, 1, [&](std::size_t, std::size_t) {
        EXPECT_EQ(current_memory_limit(), outer) << "and in the threads of loops";
      });
    });
  });
}

}  // namespace
}  // namespace relief
