#include "fusion/memory/memory_limit.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/vfs.h>
#include <unistd.h>

#include "scan/base/parallel.h"
#include "scan/base/system/system_memory.h"

namespace relief::fusion {

namespace {

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

// The part of a limit up to which arrays lie in memory. Takes at most so much from what the rest of
// the work may need, which no file can hold. Changes no result.
constexpr std::size_t kAmple = 8;

std::filesystem::path default_folder() {
  const char* given = std::getenv("TMPDIR");
  return given && *given ? given : "/tmp";
}

// A file without a name; -1 and errno when there can be none.
int open_nameless(const std::filesystem::path& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR)) return file;
  // Some file systems have no such files.
  std::string name = (folder / ".relief-XXXXXX").string();
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

std::string mebibytes(std::size_t bytes) {
  return std::to_string((bytes + kMebibyte - 1) / kMebibyte) + " MiB";
}

}  // namespace

MemoryLimit::MemoryLimit(std::size_t limit, std::filesystem::path folder,
                         std::function<std::size_t()> resident)
    : limit_(limit),
      folder_(folder.empty() ? default_folder() : std::move(folder)),
      resident_(resident ? std::move(resident) : [] { return resident_memory(); }) {}

bool MemoryLimit::keep_in_memory(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  const std::size_t most = limit_ / kAmple;
  if (in_memory_ + bytes > most || resident_() + in_memory_ + bytes > most) return false;
  in_memory_ += bytes;
  return true;
}

void MemoryLimit::evict_pages(std::size_t needed) {
  if (resident_() + needed <= limit_) return;
  const std::lock_guard lock(mutex_);
  if (resident_() + needed <= limit_) return;  // another thread was first
  // The content of shared mappings stays in their files.
  for (const auto& [address, bytes] : blocks_) ::madvise(address, bytes, MADV_DONTNEED);
  release_freed_memory();
  ++releases_;
  const std::size_t left = resident_();
  if (left + needed > limit_)
    fail(ErrorKind::kUnsolvable, "the memory limit of " + mebibytes(limit_) +
                                     " cannot be kept: at this point " + mebibytes(left + needed) +
                                     " are needed; raise the limit or the voxel size");
}

void MemoryLimit::fail(ErrorKind kind, const std::string& message) {
  if (!failure_) failure_ = Error{kind, message};
}

Result<void> MemoryLimit::check() const {
  const std::lock_guard lock(mutex_);
  if (failure_) return *failure_;
  return {};
}

bool MemoryLimit::folder_is_memory() const {
  constexpr long kTmpfs = 0x01021994, kRamfs = -2054924042;  // 0x858458f6
  struct statfs status {};
  if (::statfs(folder_.c_str(), &status) != 0) return false;
  return status.f_type == kTmpfs || static_cast<int>(status.f_type) == kRamfs;
}

std::size_t MemoryLimit::releases() const {
  const std::lock_guard lock(mutex_);
  return releases_;
}

void* MemoryLimit::map_file(int file, std::size_t bytes) {
  // All of the space at once: a disk that fills up later would be a fatal signal.
  if (const int code = ::posix_fallocate(file, 0, static_cast<off_t>(bytes)); code != 0) {
    errno = code;
    return nullptr;
  }
  void* const address = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  return address == MAP_FAILED ? nullptr : address;
}

void* MemoryLimit::map(std::size_t bytes) {
  const int file = open_nameless(folder_);
  void* const address = file < 0 ? nullptr : map_file(file, bytes);
  const int code = errno;
  if (file >= 0) ::close(file);  // the mapping keeps it
  const std::lock_guard lock(mutex_);
  if (address)
    blocks_.emplace(address, bytes);
  else
    fail(ErrorKind::kCannotWrite, folder_.string() + ": cannot make a temporary file of " +
                                      mebibytes(bytes) + ": " + std::strerror(code) +
                                      "; merge without a memory limit or make room");
  return address;
}

void MemoryLimit::unmap(void* address) {
  const std::lock_guard lock(mutex_);
  const auto block = blocks_.find(address);
  ::munmap(address, block->second);
  blocks_.erase(block);
}

}  // namespace relief::fusion
