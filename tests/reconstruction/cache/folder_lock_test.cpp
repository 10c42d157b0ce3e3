#include "reconstruction/cache/folder_lock.h"

#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief::reconstruction {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryFolder;

TEST(FolderLock, TellsWhoHoldsTheFolder) {
  const TemporaryFolder folder;
  const auto first = value_of(FolderLock::acquire(folder.path()));
  EXPECT_TRUE(first.held());
  EXPECT_THAT(FolderLock::acquire(folder.path()),
              HasError(ErrorKind::kCannotWrite, folder.path().string(),
                       "process " + std::to_string(getpid()) + " on ", "UTC"));
}

TEST(FolderLock, EndsWithTheObject) {
  const TemporaryFolder folder;
  { const auto first = FolderLock::acquire(folder.path()); }
  EXPECT_THAT(FolderLock::acquire(folder.path()), IsOk());
}

TEST(FolderLock, MayBeRemovedByItsHolder) {
  const TemporaryFolder folder;
  auto first = FolderLock::acquire(folder.path());
  fs::remove_all(private_folder(folder.path()));
  const auto second = FolderLock::acquire(folder.path());
  EXPECT_THAT(second, IsOk());
  EXPECT_THAT(FolderLock::acquire(folder.path()), HasError());
}

// The child holds the folder until it is killed, with files half written.
TEST(FolderLock, DoesNotOutliveAKilledProcessWhoseUnfinishedFilesGo) {
  const TemporaryFolder folder;
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto lock = FolderLock::acquire(folder.path());
    const char told = lock ? 'y' : 'n';
    if (write(ready[1], &told, 1) != 1) _exit(1);
    for (;;) pause();
  }
  char told = 0;
  ASSERT_EQ(read(ready[0], &told, 1), 1);
  EXPECT_EQ(told, 'y');
  const std::string own = ".partial-" + std::to_string(child) + "-0";
  fs::create_directories(private_folder(folder.path()) / "cache");
  folder.write(".model" + own + ".ply", "half");
  folder.write(".relief/cache/.unit" + own, "half");
  folder.write(".model.partial-" + std::to_string(child) + "9-0.ply", "another's");
  folder.write("model.ply", "whole");
  EXPECT_THAT(FolderLock::acquire(folder.path()), HasError());
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_THAT(FolderLock::acquire(folder.path()), IsOk());
  EXPECT_FALSE(fs::exists(folder / (".model" + own + ".ply")));
  EXPECT_FALSE(fs::exists(folder / (".relief/cache/.unit" + own)));
  EXPECT_TRUE(fs::exists(folder / (".model.partial-" + std::to_string(child) + "9-0.ply")));
  EXPECT_TRUE(fs::exists(folder / "model.ply"));
}

TEST(FolderLock, IsSharedBySteps) {
  const TemporaryFolder folder;
  const auto first = value_of(FolderLock::acquire(folder.path(), FolderUse::kShared));
  const auto second = value_of(FolderLock::acquire(folder.path(), FolderUse::kShared));
  EXPECT_TRUE(first.held() && second.held());
  EXPECT_THAT(FolderLock::acquire(folder.path()),
              HasError(ErrorKind::kCannotWrite, "steps work in this folder",
                       "process " + std::to_string(getpid()) + " on "));
}

TEST(FolderLock, OfARunKeepsStepsOut) {
  const TemporaryFolder folder;
  {
    const auto run = value_of(FolderLock::acquire(folder.path()));
    EXPECT_THAT(FolderLock::acquire(folder.path(), FolderUse::kShared),
                HasError(ErrorKind::kCannotWrite, "a run works in this folder already"));
  }
  { const auto step = value_of(FolderLock::acquire(folder.path(), FolderUse::kShared)); }
  EXPECT_THAT(FolderLock::acquire(folder.path()), IsOk());
}

// Of any process on any host: only a run, which is alone, can tell that nobody writes them.
TEST(FolderLock, RemovesTheUnfinishedUnitsOfStepsForARun) {
  const TemporaryFolder folder;
  { const auto step = value_of(FolderLock::acquire(folder.path(), FolderUse::kShared)); }
  fs::create_directories(private_folder(folder.path()) / "cache");
  const auto unfinished = folder.write(".relief/cache/.unit.partial-12-elsewhere-0", "half");
  { const auto step = value_of(FolderLock::acquire(folder.path(), FolderUse::kShared)); }
  EXPECT_TRUE(fs::exists(unfinished));
  EXPECT_THAT(FolderLock::acquire(folder.path()), IsOk());
  EXPECT_FALSE(fs::exists(unfinished));
}

TEST(FolderLock, NeedsAFolder) {
  const TemporaryFolder folder;
  EXPECT_THAT(FolderLock::acquire(folder.write("file", "")), HasError(ErrorKind::kCannotWrite));
}

}  // namespace
}  // namespace relief::reconstruction
