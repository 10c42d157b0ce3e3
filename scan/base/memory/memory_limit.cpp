#include "scan/base/memory/memory_limit.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/vfs.h>
#include <unistd.h>

#include "scan/base/parallel.h"
#include "scan/base/system/system_memory.h"

namespace relief {

namespace {

constexpr std::size_t kMebibyte = std::size_t{1} << 20;

// Grids lie in memory as long as the process has no more than this part of the limit.
constexpr std::size_t kQuarter = 4;

std::filesystem::path default_folder() {
  const char* given = std::getenv("TMPDIR");
  return given && *given ? given : "/tmp";
}

// Half of the mappings that Linux lets a process have (vm.max_map_count). Later grids lie in
// memory.
constexpr std::size_t kMostFiles = 32768;

// Before so much is allocated the memory is looked at in any case [bytes].
constexpr std::size_t kLarge = std::size_t{1} << 20;

// How long loops do not look at the memory again, and how long where evicting cannot help.
constexpr std::chrono::nanoseconds kPause = std::chrono::milliseconds(2);
constexpr std::chrono::nanoseconds kLongPause = std::chrono::seconds(1);

// How often pages are evicted once more before a limit counts as one that cannot be kept. Pieces of
// work take some milliseconds; what lies in no file stays.
constexpr int kEvictions = 25;

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

// The whole of a file, made that large; null and errno when there is no room.
void* mapped(int file, std::size_t bytes) {
  // All of the space at once: a disk that fills up later would be a fatal signal.
  if (const int code = ::posix_fallocate(file, 0, static_cast<off_t>(bytes)); code != 0) {
    errno = code;
    return nullptr;
  }
  void* const address = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  return address == MAP_FAILED ? nullptr : address;
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

MemoryLimit::~MemoryLimit() {
  for (const auto& [address, bytes] : files_) ::munmap(address, bytes);
}

bool MemoryLimit::keep_in_memory(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  const std::size_t most = most_in_memory();
  if (in_memory_ + bytes > most || resident_() + in_memory_ + bytes > most) return false;
  in_memory_ += bytes;
  return true;
}

std::size_t MemoryLimit::touched_at_once() const {
  return std::clamp(limit_ / kLoopPart, kLoopBytes, kMostLoopBytes);
}

std::size_t MemoryLimit::room_for_loops() const {
  const std::size_t used = resident_() + touched_at_once();
  return used < limit_ ? limit_ - used : 0;
}

// Not by what is resident afterwards: other threads fetch pages meanwhile.
bool MemoryLimit::can_make_room_for_loops() const {
  return anonymous_memory() + touched_at_once() <= limit_;
}

void MemoryLimit::evict_pages(std::size_t needed) {
  if (resident_() + needed <= limit_) return;
  const std::lock_guard lock(mutex_);
  if (resident_() + needed <= limit_) return;  // another thread was first
  // Other threads fetch pages until they look at the memory themselves.
  std::size_t left = evict_all();
  for (int again = 0; left + needed > limit_ && again < kEvictions; ++again) {
    std::this_thread::sleep_for(kPause);
    left = evict_all();
  }
  if (left + needed > limit_)
    fail(ErrorKind::kUnsolvable, "the memory limit of " + mebibytes(limit_) +
                                     " cannot be kept: at this point " + mebibytes(left + needed) +
                                     " are needed; raise the limit or the voxel size");
}

void MemoryLimit::evict_in_time(std::size_t needed) {
  const std::int64_t now =
      std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
  if (evicting_) const std::lock_guard wait(mutex_);  // Else pages come back as fast as they go.
  if (now < (needed < kLarge ? next_look_ : next_eviction_)) return;
  next_look_ = now + kPause.count();
  const std::size_t touched = touched_at_once();
  needed = touched + std::min(needed, touched);  // More is not touched at once.
  if (resident_() + needed <= limit_) return;
  const std::lock_guard lock(mutex_);
  if (resident_() + needed <= limit_) return;
  evict_all();
  if (!can_make_room_for_loops()) next_look_ = next_eviction_ = now + kLongPause.count();
}

// What is resident then. The content of shared mappings stays in their files.
std::size_t MemoryLimit::evict_all() {
  evicting_ = true;
  for (const auto& [address, bytes] : files_) ::madvise(address, bytes, MADV_DONTNEED);
  evicting_ = false;
  release_freed_memory();
  ++releases_;
  return resident_();
}

std::size_t MemoryLimit::evict() {
  const std::lock_guard lock(mutex_);
  return evict_all();
}

std::size_t resident_beyond_files() {
  MemoryLimit* const limit = current_memory_limit();
  return limit ? limit->evict() : resident_memory();
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

MemoryLimit::MappedFile MemoryLimit::new_file(std::size_t bytes) const {
  const int file = open_nameless(folder_);
  void* const address = file < 0 ? nullptr : mapped(file, bytes);
  const int code = errno;
  if (file >= 0) ::close(file);  // the mapping keeps it
  return {address, bytes, code};
}

void* MemoryLimit::keep(const MappedFile& file) {
  if (file.address)
    files_.emplace(file.address, file.bytes);
  else
    fail(ErrorKind::kCannotWrite, folder_.string() + ": cannot make a temporary file of " +
                                      mebibytes(file.bytes) + ": " + std::strerror(file.code) +
                                      "; make room, or work without a memory limit");
  return file.address;
}

void* MemoryLimit::map(std::size_t bytes) {
  if (bytes <= FilePieces::kLargest) {
    const std::lock_guard lock(mutex_);
    return pieces_.take(bytes);
  }
  const MappedFile file = new_file(bytes);  // Others need not wait for it.
  const std::lock_guard lock(mutex_);
  return keep(file);
}

bool MemoryLimit::release(void* address, std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  if (bytes <= FilePieces::kLargest && pieces_.give_back(address, bytes)) return true;
  const auto file = files_.find(address);
  if (file == files_.end()) {
    in_memory_ -= std::min(in_memory_, bytes);
    return false;
  }
  ::munmap(address, file->second);
  files_.erase(file);
  return true;
}

bool MemoryLimit::keep_grid_in_memory(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  const bool ample =
      in_memory_ + bytes <= most_in_memory() && resident_() + bytes <= limit_ / kQuarter;
  if (!ample && files_.size() < kMostFiles) return false;
  in_memory_ += bytes;
  return true;
}

void* MemoryLimit::allocate(std::size_t bytes) {
  if (bytes >= kSmallArray && !keep_grid_in_memory(bytes)) {
    evict_in_time(bytes);
    if (void* const mapped = map(bytes)) return mapped;
  }
  return ::operator new(bytes);
}

void MemoryLimit::deallocate(void* address, std::size_t bytes) {
  if (bytes >= kSmallArray && release(address, bytes)) return;
  ::operator delete(address, bytes);
}

}  // namespace relief
