#include "scan/base/system/system_memory.h"

#include <string>

#include <gtest/gtest.h>

#include "scan/base/system/control_groups.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::TemporaryFolder;

constexpr std::size_t kMega = std::size_t{1} << 20;

std::string megabytes(std::size_t count) { return std::to_string(count * kMega) + "\n"; }

// A machine of 8 GiB, 6 GiB of them free.
class SystemMemory : public ::testing::Test {
 protected:
  SystemMemory() {
    write(
        "proc/meminfo",
        "MemTotal:        8388608 kB\nMemFree:          1048576 kB\nMemAvailable:    6291456 kB\n");
  }
  void write(const std::string& name, const std::string& content) {
    std::filesystem::create_directories((root_ / name).parent_path());
    root_.write(name, content);
  }
  std::size_t usable() const { return usable_memory(root_.path()) / kMega; }
  std::size_t free() const { return free_memory(root_.path()) / kMega; }

  TemporaryFolder root_;
};

TEST_F(SystemMemory, IsThatOfTheMachineWithoutGroups) {
  EXPECT_EQ(usable(), 8192u);
  EXPECT_EQ(free(), 6144u);
}

TEST_F(SystemMemory, HasTheLimitOfAGroupOfVersion2) {
  write("proc/self/cgroup", "0::/jobs/mine\n");
  write("sys/fs/cgroup/jobs/mine/memory.max", megabytes(2048));
  write("sys/fs/cgroup/jobs/mine/memory.current", megabytes(1500));
  write("sys/fs/cgroup/jobs/mine/memory.stat", "anon 1\nfile 2\ninactive_file " + megabytes(500));
  EXPECT_EQ(usable(), 2048u);
  EXPECT_EQ(free(), 1048u);
}

TEST_F(SystemMemory, HasTheLeastLimitOfTheGroupsAround) {
  write("proc/self/cgroup", "0::/jobs/mine\n");
  write("sys/fs/cgroup/jobs/mine/memory.max", "max\n");
  write("sys/fs/cgroup/jobs/mine/memory.current", megabytes(10));
  write("sys/fs/cgroup/jobs/memory.max", megabytes(3000));
  write("sys/fs/cgroup/jobs/memory.current", megabytes(2900));
  EXPECT_EQ(usable(), 3000u);
  EXPECT_EQ(free(), 100u);
}

TEST_F(SystemMemory, HasTheLimitOfAGroupOfVersion1) {
  write("proc/self/cgroup", "5:cpu,cpuacct:/a\n4:memory:/a/b\n0::/\n");
  write("sys/fs/cgroup/memory/a/b/memory.limit_in_bytes", megabytes(1024));
  write("sys/fs/cgroup/memory/a/b/memory.usage_in_bytes", megabytes(1000));
  write("sys/fs/cgroup/memory/a/b/memory.stat",
        "inactive_file 1\ntotal_inactive_file " + megabytes(24));
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  write("sys/fs/cgroup/memory/memory.usage_in_bytes", megabytes(5000));
  EXPECT_EQ(usable(), 1024u);
  EXPECT_EQ(free(), 48u);
}

TEST_F(SystemMemory, OfGroupsIsWhatTheProcessHasAndWhatIsFreeInThem) {
  EXPECT_EQ(memory_in_groups(root_.path()), 0u) << "no group limits it";
  write("proc/self/cgroup", "0::/jobs/mine\n");
  write("sys/fs/cgroup/jobs/mine/memory.max", megabytes(2048));
  write("sys/fs/cgroup/jobs/mine/memory.current", megabytes(1500));
  write("sys/fs/cgroup/jobs/mine/memory.stat", "inactive_file " + megabytes(500));
  EXPECT_GE(memory_in_groups(root_.path()), 1048 * kMega);
  EXPECT_LT(memory_in_groups(root_.path()), 2048 * kMega);
  write("sys/fs/cgroup/jobs/mine/memory.max", megabytes(100000));
  EXPECT_EQ(memory_in_groups(root_.path()), 0u) << "a limit above the machine is none";
}

// A container sees its own group as the root, but may be told the path that the host knows.
TEST_F(SystemMemory, HasTheLimitOfAContainer) {
  write("proc/self/cgroup", "0::/docker/0123456789abcdef\n");
  write("sys/fs/cgroup/memory.max", megabytes(512));
  write("sys/fs/cgroup/memory.current", megabytes(512));
  EXPECT_EQ(usable(), 512u);
  EXPECT_EQ(free(), 0u);
}

TEST_F(SystemMemory, IgnoresLimitsAboveTheMachineAndWhatIsNoNumber) {
  write("proc/self/cgroup", "nonsense\n0::/a\n");
  write("sys/fs/cgroup/a/memory.max", megabytes(100000));
  write("sys/fs/cgroup/memory.max", "lots\n");
  EXPECT_EQ(usable(), 8192u);
  EXPECT_EQ(free(), 6144u);
}

TEST(SystemMemoryOfThisMachine, IsPositive) {
  EXPECT_GT(free_memory(), 0u);
  EXPECT_LE(free_memory(), usable_memory());
}

}  // namespace
}  // namespace relief
