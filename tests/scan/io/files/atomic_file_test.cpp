#include "scan/io/files/atomic_file.h"

#include <csignal>
#include <cstring>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFolder;

TEST(AtomicFile, WritesAndReplaces) {
  const TemporaryFolder folder;
  const auto path = folder / "a.txt";
  ASSERT_TRUE(write_file(path, "first").ok());
  ASSERT_TRUE(write_file(path, std::string(100000, 'x')).ok());
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
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().kind, ErrorKind::kCannotWrite);
  EXPECT_THAT(result.error().message, HasSubstr(path.string()));
  EXPECT_THAT(result.error().message, HasSubstr("the writer gave up"));
  EXPECT_EQ(*read_file(path), "old");
  EXPECT_EQ(folder.size(), 1u);
}

TEST(AtomicFile, NamesAFolderThatIsNotThere) {
  const TemporaryFolder folder;
  const auto result = write_file(folder / "no/such/a.txt", "text");
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().kind, ErrorKind::kCannotWrite);
  EXPECT_THAT(result.error().message, HasSubstr("no/such does not exist"));
}

TEST(AtomicFile, RefusesAFolderAsFile) {
  const TemporaryFolder folder;
  EXPECT_FALSE(write_file(folder.path(), "text").ok());
  EXPECT_FALSE(read_file(folder.path()).ok());
}

TEST(AtomicFile, AReadOnlyPlaceIsAnError) {
  // The kernel's own file system takes no new files, not even from the superuser.
  const auto result = write_file("/proc/relief-test.txt", "text");
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().kind, ErrorKind::kCannotWrite);
  EXPECT_THAT(result.error().message, HasSubstr("/proc/relief-test.txt"));
}

TEST(AtomicFile, AFullDeviceIsAnError) {
  const auto result = write_file("/dev/full", "text");
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().kind, ErrorKind::kCannotWrite);
  EXPECT_THAT(result.error().message, HasSubstr(std::strerror(ENOSPC)));
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
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().message, HasSubstr(std::strerror(EFBIG)));
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
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().message, HasSubstr(std::strerror(ENOSPC)));
  EXPECT_EQ(*old, "old");
  EXPECT_EQ(entries, 1u);
}

TEST(AtomicFile, ALinkStaysALink) {
  const TemporaryFolder folder;
  const auto target = folder.write("target.txt", "old");
  const auto link = folder / "link.txt";
  std::filesystem::create_symlink(target, link);
  ASSERT_TRUE(write_file(link, "new").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(*read_file(target), "new");
}

TEST(AtomicFile, AMissingFileIsBadInput) {
  const auto result = read_file("/no/such/file");
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().kind, ErrorKind::kBadInput);
  EXPECT_THAT(result.error().message, HasSubstr("/no/such/file"));
}

}  // namespace
}  // namespace relief
