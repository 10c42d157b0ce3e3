#include "relief/reconstruction/unit_folder.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scan/base/parallel.h"
#include "scan/base/system/file_descriptor.h"
#include "scan/base/system/host_name.h"
#include "scan/units/content_hash.h"

namespace relief::reconstruction {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHashDigits = 64;
// [bytes] Read or written in tenths of a second.
constexpr std::size_t kPiece = std::size_t{32} << 20;

bool is_hash(const std::string& name) {
  return name.size() == kHashDigits &&
         name.find_first_not_of("0123456789abcdef") == std::string::npos;
}

// The first line of a file. A single wrong bit in it or in the content makes it another one.
std::string head_of(const UnitKey& key, std::string_view content) {
  const std::string checksum = ContentHash().add_bytes(content.data(), content.size()).hex();
  return "relief-unit " + std::to_string(kUnitFormat) + " " + key.kind + " " + key.hash + " " +
         std::to_string(content.size()) + " " + checksum + "\n";
}

// Nothing when the file cannot be read to its end.
std::optional<std::string> content_of(const FileDescriptor& file) {
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return std::nullopt;
  const auto size = static_cast<std::size_t>(status.st_size);
  std::string content;
  content.reserve(size);
  for (std::size_t at = 0; at < size;) {
    check_stop_and_memory();
    if (at == content.size()) content.resize(std::min(size, at + kPiece));
    const ssize_t count = ::read(file.get(), content.data() + at, content.size() - at);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return std::nullopt;
    at += static_cast<std::size_t>(count);
  }
  return content;
}

bool write_all(const FileDescriptor& file, std::string_view bytes) {
  for (std::size_t at = 0; at < bytes.size();) {
    if (at >= kPiece) check_stop_and_memory();
    const ssize_t count =
        ::write(file.get(), bytes.data() + at, std::min(kPiece, bytes.size() - at));
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) errno = ENOSPC;
    if (count <= 0) return false;
    at += static_cast<std::size_t>(count);
  }
  return true;
}

// Removes a file that has not got its name, also when the work is stopped.
class PartialFile {
 public:
  explicit PartialFile(fs::path path) : path_(std::move(path)) {}
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;
  ~PartialFile() {
    if (!path_.empty()) ::unlink(path_.c_str());
  }
  const char* path() const { return path_.c_str(); }
  bool rename_to(const fs::path& path) {
    if (::rename(path_.c_str(), path.c_str()) != 0) return false;
    path_.clear();
    return true;
  }

 private:
  fs::path path_;
};

Error cannot_keep(int code) { return {ErrorKind::kCannotWrite, std::strerror(code)}; }

}  // namespace

Result<std::unique_ptr<UnitFolder>> UnitFolder::open(const fs::path& folder,
                                                     const UnitFolderOptions& options) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure)
    return Error{ErrorKind::kCannotWrite,
                 folder.string() + ": cannot create this folder: " + failure.message()};
  std::unique_ptr<UnitFolder> opened(new UnitFolder(folder, options));
  opened->take_stock();
  return opened;
}

void UnitFolder::take_stock() {
  std::error_code ignored;
  for (auto entry = fs::recursive_directory_iterator(folder_, ignored);
       entry != fs::recursive_directory_iterator(); entry.increment(ignored)) {
    const std::string name = entry->path().filename().string();
    if (!is_hash(name) || !entry->is_regular_file(ignored)) continue;
    const File file{entry->file_size(ignored), entry->last_write_time(ignored), false};
    bytes_ += file.bytes;
    files_[name] = file;
  }
}

fs::path UnitFolder::path_of(const std::string& hash) const {
  return folder_ / hash.substr(0, 2) / hash;
}

std::optional<std::string> UnitFolder::find(const UnitKey& key) {
  if (options_.fresh) return std::nullopt;
  auto content = read(key);
  if (!content) return std::nullopt;
  // The time of the file is that of its last use; where that cannot be set, it goes earlier.
  (void)::utimensat(AT_FDCWD, path_of(key.hash).c_str(), nullptr, 0);
  const std::scoped_lock lock(mutex_);
  files_[key.hash].of_this_run = true;
  ++counts_[key.kind].found;
  return content;
}

std::optional<std::string> UnitFolder::read(const UnitKey& key) {
  const fs::path path = path_of(key.hash);
  std::optional<std::string> content;
  {
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.is_open() && errno == ENOENT) return std::nullopt;
    if (file.is_open()) content = content_of(file);
  }
  if (content) {
    const std::size_t begin = std::min(content->find('\n'), content->size() - 1) + 1;
    const std::string head = content->substr(0, begin);
    content->erase(0, begin);
    if (head == head_of(key, *content)) return content;
  }
  const std::scoped_lock lock(mutex_);
  forget(key.hash);
  warnings_.push_back(path.string() + ": this kept result is damaged; it is computed again");
  return std::nullopt;
}

void UnitFolder::forget(const std::string& hash) {
  std::error_code ignored;
  fs::remove(path_of(hash), ignored);
  give_back_room(hash);
}

void UnitFolder::give_back_room(const std::string& hash) {
  const auto file = files_.find(hash);
  if (file == files_.end()) return;
  bytes_ -= file->second.bytes;
  files_.erase(file);
}

void UnitFolder::keep(const UnitKey& key, std::string_view content) {
  const std::string head = head_of(key, content);
  const std::uint64_t bytes = head.size() + content.size();
  {
    const std::scoped_lock lock(mutex_);
    ++counts_[key.kind].computed;
    if (!make_room(key.hash, bytes)) {
      ++not_kept_;
      warn_once("limit", folder_.string() +
                             ": the results of this run take more than the limit of the cache; "
                             "those that find no room in it are not kept");
      return;
    }
  }
  const auto written = write_or_forget(key.hash, head, content);
  const std::scoped_lock lock(mutex_);
  if (written) {
    files_[key.hash].of_this_run = true;
    return;
  }
  ++not_kept_;
  warn_once("write", folder_.string() + ": finished results cannot be kept (" +
                         written.error().message + "); the run goes on without");
}

// Takes the room for a file, too, so that all threads together stay within the limit. A file of
// this key stays until the new one takes its place: another process may be about to read it.
bool UnitFolder::make_room(const std::string& hash, std::uint64_t bytes) {
  give_back_room(hash);
  std::vector<std::pair<fs::file_time_type, std::string>> idle;
  for (const auto& [name, file] : files_)
    if (!file.of_this_run) idle.emplace_back(file.used, name);
  std::sort(idle.begin(), idle.end());
  for (auto oldest = idle.begin(); oldest != idle.end() && bytes_ + bytes > options_.limit;
       ++oldest)
    forget(oldest->second);
  if (bytes_ + bytes > options_.limit) {
    forget(hash);
    return false;
  }
  files_[hash] = {bytes, fs::file_time_type::clock::now(), true};
  bytes_ += bytes;
  return true;
}

// Takes no room for a file that it could not write, or that it was stopped at.
Result<void> UnitFolder::write_or_forget(const std::string& hash, const std::string& head,
                                         std::string_view content) {
  const auto forget_it = [&] {
    const std::scoped_lock lock(mutex_);
    forget(hash);
  };
  try {
    auto written = write(hash, head, content);
    if (!written) forget_it();
    return written;
  } catch (...) {
    forget_it();
    throw;
  }
}

// Not flushed to the disk: a file that a power failure spoils is noticed by its checksum.
Result<void> UnitFolder::write(const std::string& hash, const std::string& head,
                               std::string_view content) {
  // Processes of several hosts write into one folder.
  std::string name = ".unit.partial-" + std::to_string(::getpid()) + "-" + host_name() + "-";
  {
    const std::scoped_lock lock(mutex_);
    name += std::to_string(written_++);
  }
  const fs::path path = path_of(hash);
  std::error_code failure;
  fs::create_directory(path.parent_path(), failure);
  if (failure) return cannot_keep(failure.value());
  PartialFile partial(folder_ / name);
  FileDescriptor file(::open(partial.path(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (!file.is_open()) return cannot_keep(errno);
  if (write_all(file, head) && write_all(file, content) && file.close() && partial.rename_to(path))
    return {};
  return cannot_keep(errno);
}

void UnitFolder::warn_once(const std::string& topic, const std::string& warning) {
  if (!std::exchange(warned_[topic], true)) warnings_.push_back(warning);
}

std::map<std::string, UnitCounts> UnitFolder::counts() const {
  const std::scoped_lock lock(mutex_);
  return counts_;
}

std::vector<std::string> UnitFolder::take_warnings() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(warnings_, {});
}

std::size_t UnitFolder::not_kept() const {
  const std::scoped_lock lock(mutex_);
  return not_kept_;
}

std::size_t UnitFolder::files() const {
  const std::scoped_lock lock(mutex_);
  return files_.size();
}

std::uint64_t UnitFolder::bytes() const {
  const std::scoped_lock lock(mutex_);
  return bytes_;
}

}  // namespace relief::reconstruction
