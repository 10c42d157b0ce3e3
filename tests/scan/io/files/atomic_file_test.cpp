#include "scan/io/files/atomic_file.h"

#include <csignal>
#include <cstring>
#include <fstream>
#include <stop_token>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include "relief/scan/context.h"
#include "tests/support/result_matchers.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::TemporaryFolder;

TEST(AtomicFile, WritesAndReplaces) {
  const TemporaryFolder folder;
  const auto path = folder / "a.txt";
  ASSERT_THAT(write_file(path, "first"), IsOk());
  ASSERT_THAT(write_file(path, std::string(100000, 'x')), IsOk());
  EXPECT_EQ(*read_file(path), std::string(100000, 'x'));
  EXPECT_EQ(folder.size(), 1u);
}

TEST(AtomicFile, AFailedWriterLeavesTheOldFileAndNothingElse) {
  const TemporaryFolder folder;
  const auto path = folder.write("model.ply", "old");
  const auto result = write_atomically(path, [](const auto& temporary) -> Result<void> {
    EXPECT_EQ(temporary.extension(), ".ply");
    std::ofstream(temporary) << "half";
    return Error{ErrorKind::kCannotWrite, "the writer gave up"};
  });
  EXPECT_THAT(result, HasError(ErrorKind::kCannotWrite, path.string(), "the writer gave up"));
  EXPECT_EQ(*read_file(path), "old");
  EXPECT_EQ(folder.size(), 1u);
}

TEST(AtomicFile, AStoppedWriterLeavesTheOldFileAndNothingElse) {
  const TemporaryFolder folder;
  const auto path = folder.write("model.ply", "old");
  std::stop_source source;
  source.request_stop();
  const auto result = run_in({.threads = 1, .stop = source.get_token()},
                             [&] { return write_file(path, std::string(100000, 'x')); });
  EXPECT_THAT(result, HasError(ErrorKind::kInterrupted));
  EXPECT_EQ(*read_file(path), "old");
  EXPECT_EQ(folder.size(), 1u);
}

TEST(AtomicFile, WritesMoreThanOnePiece) {
  const TemporaryFolder folder;
  std::string content(70'000'001, '\0');  // Pieces have 32 MiB.
  for (std::size_t k = 0; k < content.size(); k += 997) content[k] = static_cast<char>(k);
  ASSERT_THAT(write_file(folder / "large", content), IsOk());
  EXPECT_TRUE(*read_file(folder / "large") == content);
}

TEST(AtomicFile, NamesAFolderThatIsNotThere) {
  const TemporaryFolder folder;
  EXPECT_THAT(write_file(folder / "no/such/a.txt", "text"),
              HasError(ErrorKind::kCannotWrite, "no/such does not exist"));
}

TEST(AtomicFile, RefusesAFolderAsFile) {
  const TemporaryFolder folder;
  EXPECT_THAT(write_file(folder.path(), "text"), HasError());
  EXPECT_THAT(read_file(folder.path()), HasError());
}

TEST(AtomicFile, AReadOnlyPlaceIsAnError) {
  // The kernel's own file system takes no new files, not even from the superuser.
  EXPECT_THAT(write_file("/proc/relief-test.txt", "text"),
              HasError(ErrorKind::kCannotWrite, "/proc/relief-test.txt"));
}

TEST(AtomicFile, AFullDeviceIsAnError) {
  EXPECT_THAT(write_file("/dev/full", "text"),
              HasError(ErrorKind::kCannotWrite, std::strerror(ENOSPC)));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(AtomicFile, AFileSizeLimitIsAnError) {
  const TemporaryFolder folder;
  const auto path = folder.write("a.bin", "old");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{10000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto result = write_file(path, std::string(50000, 'x'));
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(result, HasError(std::strerror(EFBIG)));
  EXPECT_EQ(*read_file(path), "old");
  EXPECT_EQ(folder.size(), 1u);
}

TEST(AtomicFile, AFullDiskIsAnErrorAndLeavesTheOldFile) {
  const TemporaryFolder folder;
  if (::mount("relief-test", folder.path().c_str(), "tmpfs", 0, "size=64k") != 0)
    GTEST_SKIP() << "cannot mount a small disk here: " << std::strerror(errno);
  const auto path = folder.write("a.bin", "old");
  const auto result = write_file(path, std::string(200000, 'x'));
  const auto old = read_file(path);
  const std::size_t entries = folder.size();
  ::umount(folder.path().c_str());
  EXPECT_THAT(result, HasError(std::strerror(ENOSPC)));
  EXPECT_EQ(*old, "old");
  EXPECT_EQ(entries, 1u);
}

TEST(AtomicFile, ALinkStaysALink) {
  const TemporaryFolder folder;
  const auto target = folder.write("target.txt", "old");
  const auto link = folder / "link.txt";
  std::filesystem::create_symlink(target, link);
  ASSERT_THAT(write_file(link, "new"), IsOk());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(*read_file(target), "new");
}

TEST(AtomicFile, AMissingFileIsBadInput) {
  EXPECT_THAT(read_file("/no/such/file"), HasError(ErrorKind::kBadInput, "/no/such/file"));
}

}  // namespace
}  // namespace relief
