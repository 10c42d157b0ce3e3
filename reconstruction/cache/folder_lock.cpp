#include "relief/reconstruction/folder_lock.h"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace relief::reconstruction {

namespace {

namespace fs = std::filesystem;

Error cannot_lock(const fs::path& file, int code) {
  return {ErrorKind::kCannotWrite,
          file.string() + ": cannot create the lock of this folder: " + std::strerror(code)};
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

// One line: process, host, start in UTC.
std::string own_record() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::array<char, 32> start{};
  std::strftime(start.data(), start.size(), "%Y-%m-%d %H:%M:%S UTC", &utc);
  return std::to_string(::getpid()) + " " + host_name() + " " + start.data() + "\n";
}

std::string read_record(int descriptor) {
  std::array<char, 512> text{};
  const ssize_t count = ::pread(descriptor, text.data(), text.size() - 1, 0);
  std::string record(text.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
  return record.substr(0, record.find('\n'));
}

Error held_by(const fs::path& output, const std::string& record) {
  const std::size_t host = record.find(' '), start = record.find(' ', host + 1);
  std::string who = "another process";
  if (start != std::string::npos)
    who = "process " + record.substr(0, host) + " on " + record.substr(host + 1, start - host - 1) +
          ", since " + record.substr(start + 1);
  return {ErrorKind::kCannotWrite, output.string() + ": a run works in this folder already (" +
                                       who + "); wait for it, or give another folder"};
}

// `relief clean` removes the file: a lock on one that has gone keeps nobody out.
bool still_there(int descriptor, const fs::path& file) {
  struct stat opened {
  }, named{};
  return ::fstat(descriptor, &opened) == 0 && ::stat(file.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

void remove_partials(const fs::path& folder, const std::string& process) {
  std::error_code ignored;
  for (auto entry = fs::directory_iterator(folder, ignored); entry != fs::directory_iterator();
       entry.increment(ignored)) {
    const std::string name = entry->path().filename().string();
    if (name.front() == '.' && name.find(".partial-" + process + "-") != std::string::npos)
      fs::remove(entry->path(), ignored);
    if (ignored) return;
  }
}

// The process of a record that it did not take away itself was killed: it holds no lock any more.
void clear_up_after(const std::string& record, const fs::path& output) {
  const std::string process = record.substr(0, record.find(' '));
  if (process.empty() || process.find_first_not_of("0123456789") != std::string::npos) return;
  remove_partials(output, process);
  remove_partials(private_folder(output) / "cache", process);
}

// Whoever cannot write its record, on a full disk, holds the folder as well.
void write_record(int descriptor) {
  const std::string record = own_record();
  if (::ftruncate(descriptor, 0) == 0) (void)!::pwrite(descriptor, record.data(), record.size(), 0);
}

}  // namespace

std::filesystem::path private_folder(const std::filesystem::path& output) {
  return output / ".relief";
}

Result<FolderLock> FolderLock::acquire(const std::filesystem::path& output) {
  std::error_code failure;
  fs::create_directories(private_folder(output), failure);
  const fs::path file = private_folder(output) / "lock";
  if (failure) return cannot_lock(file, failure.value());
  for (;;) {
    const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor < 0) return cannot_lock(file, errno);
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
      const int code = errno;
      if (code != EWOULDBLOCK) return FolderLock(descriptor, false);
      const std::string record = read_record(descriptor);
      ::close(descriptor);
      return held_by(output, record);
    }
    if (still_there(descriptor, file)) {
      clear_up_after(read_record(descriptor), output);
      write_record(descriptor);
      return FolderLock(descriptor, true);
    }
    ::close(descriptor);
  }
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), held_(other.held_) {}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  if (held_) (void)!::ftruncate(descriptor_, 0);
  ::close(descriptor_);
}

}  // namespace relief::reconstruction
