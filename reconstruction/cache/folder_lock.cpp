#include "reconstruction/cache/folder_lock.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scan/base/system/host_name.h"

namespace relief::reconstruction {

namespace {

namespace fs = std::filesystem;

Error cannot_lock(const fs::path& file, int code) {
  return {ErrorKind::kCannotWrite,
          file.string() + ": cannot create the lock of this folder: " + std::strerror(code)};
}

constexpr std::string_view kOfStep = "step ";

// One line: process, host, start in UTC. That of a step begins with the word. Of several steps it
// is the one that came last, and it stays when they have ended.
std::string own_record(FolderUse use) {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::array<char, 32> start{};
  std::strftime(start.data(), start.size(), "%Y-%m-%d %H:%M:%S UTC", &utc);
  return std::string(use == FolderUse::kShared ? kOfStep : "") + std::to_string(::getpid()) + " " +
         host_name() + " " + start.data() + "\n";
}

std::string read_record(int descriptor) {
  std::array<char, 512> text{};
  const ssize_t count = ::pread(descriptor, text.data(), text.size() - 1, 0);
  std::string record(text.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
  return record.substr(0, record.find('\n'));
}

bool is_of_step(const std::string& record) { return record.rfind(kOfStep, 0) == 0; }

Error held_by(const fs::path& output, std::string record) {
  const bool steps = is_of_step(record);
  if (steps) record.erase(0, kOfStep.size());
  const std::size_t host = record.find(' '), start = record.find(' ', host + 1);
  std::string who = "another process";
  if (start != std::string::npos)
    who = "process " + record.substr(0, host) + " on " + record.substr(host + 1, start - host - 1) +
          ", since " + record.substr(start + 1);
  return {ErrorKind::kCannotWrite,
          output.string() + (steps ? ": steps work in this folder, the latest is (" + who +
                                         "); a run waits for them, or takes another folder"
                                   : ": a run works in this folder already (" + who +
                                         "); wait for it, or give another folder")};
}

// `relief clean` removes the file: a lock on one that has gone keeps nobody out.
bool still_there(int descriptor, const fs::path& file) {
  struct stat opened {
  }, named{};
  return ::fstat(descriptor, &opened) == 0 && ::stat(file.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

// `of`: the process whose they are, with a dash after it; empty: all.
void remove_partials(const fs::path& folder, const std::string& of) {
  std::error_code ignored;
  for (auto entry = fs::directory_iterator(folder, ignored); entry != fs::directory_iterator();
       entry.increment(ignored)) {
    const std::string name = entry->path().filename().string();
    if (name.front() == '.' && name.find(".partial-" + of) != std::string::npos)
      fs::remove(entry->path(), ignored);
    if (ignored) return;
  }
}

// The process of a record that it did not take away itself was killed: it holds no lock any more.
// Units that are half written, by steps on any host, are in the way of nobody; a run, which is
// alone, removes all of them.
void clear_up_after(const std::string& record, const fs::path& output, FolderUse use) {
  const fs::path cache = private_folder(output) / "cache";
  if (use == FolderUse::kAlone && is_of_step(record)) return remove_partials(cache, "");
  const std::string process = record.substr(0, record.find(' '));
  if (process.empty() || process.find_first_not_of("0123456789") != std::string::npos) return;
  remove_partials(output, process + "-");
  if (use == FolderUse::kAlone) remove_partials(cache, process + "-");
}

// Whoever cannot write its record, on a full disk, holds the folder as well.
void write_record(int descriptor, FolderUse use) {
  const std::string record = own_record(use);
  if (::ftruncate(descriptor, 0) == 0) (void)!::pwrite(descriptor, record.data(), record.size(), 0);
}

}  // namespace

std::filesystem::path private_folder(const std::filesystem::path& output) {
  return output / ".relief";
}

Result<FolderLock> FolderLock::acquire(const std::filesystem::path& output, FolderUse use) {
  std::error_code failure;
  fs::create_directories(private_folder(output), failure);
  const fs::path file = private_folder(output) / "lock";
  if (failure) return cannot_lock(file, failure.value());
  for (;;) {
    const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor < 0) return cannot_lock(file, errno);
    if (::flock(descriptor, (use == FolderUse::kAlone ? LOCK_EX : LOCK_SH) | LOCK_NB) != 0) {
      const int code = errno;
      if (code != EWOULDBLOCK) return FolderLock(descriptor, false, use);
      const std::string record = read_record(descriptor);
      ::close(descriptor);
      return held_by(output, record);
    }
    if (still_there(descriptor, file)) {
      clear_up_after(read_record(descriptor), output, use);
      write_record(descriptor, use);
      return FolderLock(descriptor, true, use);
    }
    ::close(descriptor);
  }
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), held_(other.held_), use_(other.use_) {}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  if (held_ && use_ == FolderUse::kAlone) (void)!::ftruncate(descriptor_, 0);
  ::close(descriptor_);
}

}  // namespace relief::reconstruction
