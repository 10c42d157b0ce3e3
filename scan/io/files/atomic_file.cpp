#include "scan/io/files/atomic_file.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scan/base/parallel.h"
#include "scan/base/system/file_descriptor.h"
#include "scan/io/files/io_error.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

Error write_error(const fs::path& path, const std::string& doing, int code) {
  return cannot_write(path, "cannot " + doing + ": " + std::strerror(code));
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

fs::path temporary_beside(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  const std::string name = "." + path.stem().string() + ".partial-" + std::to_string(getpid()) +
                           "-" + std::to_string(counter++) + path.extension().string();
  return folder_of(path) / name;
}

Result<void> check_target(const fs::path& path) {
  std::error_code code;
  if (!path.has_filename()) return cannot_write(path, "this names no file");
  if (fs::is_directory(path, code)) return cannot_write(path, "this is a folder; name a file");
  const fs::path folder = folder_of(path);
  if (!fs::is_directory(folder, code))
    return cannot_write(path, "the folder " + folder.string() + " does not exist; create it first");
  return {};
}

// Forces written bytes to the disk: only then are a full disk and a failing one known.
Result<void> flush_to_disk(const fs::path& path, const fs::path& temporary) {
  FileDescriptor file(::open(temporary.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return write_error(path, "reopen what was written", errno);
  if (::fsync(file.get()) != 0) return write_error(path, "flush to the disk", errno);
  return {};
}

void flush_folder(const fs::path& folder) {
  // Makes the new name durable; some file systems cannot, and the content is safe either way.
  const FileDescriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.is_open()) (void)::fsync(descriptor.get());
}

// The writer may know the temporary name only: the user is told the real one.
Result<void> run_writer(const fs::path& path, const fs::path& temporary,
                        const std::function<Result<void>(const fs::path&)>& write) {
  auto written = write(temporary);
  if (written || written.error().message.find(path.string()) != std::string::npos) return written;
  return cannot_write(path, written.error().message);
}

Result<void> write_and_rename(const fs::path& path, const fs::path& temporary,
                              const std::function<Result<void>(const fs::path&)>& write) {
  if (auto written = run_writer(path, temporary, write); !written) return written;
  if (auto flushed = flush_to_disk(path, temporary); !flushed) return flushed;
  if (::rename(temporary.c_str(), path.c_str()) != 0)
    return write_error(path, "rename the finished file", errno);
  flush_folder(folder_of(path));
  return {};
}

// Devices and pipes (/dev/stdout) are written to as they are: there is nothing to rename.
bool is_special(const fs::path& path) {
  std::error_code code;
  return fs::exists(path, code) && !fs::is_regular_file(path, code);
}

// Writes some bytes of the content's beginning, and takes them off it.
bool write_some(const FileDescriptor& file, std::size_t count, std::string_view& content) {
  const ssize_t written = ::write(file.get(), content.data(), count);
  if (written < 0) return errno == EINTR;
  if (written == 0) errno = ENOSPC;
  content.remove_prefix(static_cast<std::size_t>(written));
  return written > 0;
}

// Some megabytes at a time onto the disk, so that a request to stop does not wait for all of a
// large file.
class Output {
 public:
  Output(const fs::path& path, const fs::path& target)
      : path_(path),
        file_(::open(target.c_str(),
                     O_WRONLY | O_CLOEXEC | (is_special(target) ? 0 : O_CREAT | O_EXCL), 0666)) {}

  bool is_open() const { return file_.is_open(); }

  Result<void> write(std::string_view content) {
    while (!content.empty()) {
      check_stop_and_memory();
      const std::size_t before = content.size();
      if (!write_some(file_, std::min(kPiece, before), content))
        return write_error(path_, "write", errno);
      unflushed_ += before - content.size();
      if (unflushed_ < kPiece) continue;
      (void)::fdatasync(file_.get());  // Errors are known once all is flushed.
      unflushed_ = 0;
    }
    return {};
  }

  Result<void> close() {
    return file_.close() ? Result<void>() : write_error(path_, "write", errno);
  }

 private:
  static constexpr std::size_t kPiece = std::size_t{32} << 20;  // [bytes] Tenths of a second.

  const fs::path& path_;
  FileDescriptor file_;
  std::size_t unflushed_ = 0;
};

// Removes what is left of a file that did not get its name, also when the work is stopped.
class TemporaryFile {
 public:
  explicit TemporaryFile(fs::path path) : path_(std::move(path)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

Result<void> write_atomically(const fs::path& path,
                              const std::function<Result<void>(const fs::path&)>& write) {
  if (auto target = check_target(path); !target) return target;
  if (is_special(path)) return run_writer(path, path, write);
  std::error_code ignored;
  // A link stays a link: what it points to is replaced.
  const fs::path target = fs::is_symlink(path, ignored) ? fs::weakly_canonical(path) : path;
  const TemporaryFile temporary(temporary_beside(target));
  return write_and_rename(target, temporary.path(), write);
}

Result<void> write_in_pieces(const fs::path& path,
                             const std::function<Result<void>(const WritePiece&)>& produce) {
  return write_atomically(path, [&](const fs::path& target) -> Result<void> {
    Output output(path, target);
    if (!output.is_open()) return write_error(path, "create the file", errno);
    const auto produced = produce([&](std::string_view piece) { return output.write(piece); });
    return produced ? output.close() : produced;
  });
}

Result<void> write_file(const fs::path& path, std::string_view content) {
  return write_in_pieces(path, [&](const WritePiece& write) { return write(content); });
}

Result<std::string> read_file(const fs::path& path) {
  std::error_code code;
  if (fs::is_directory(path, code)) return bad_input(path, "this is a folder, not a file");
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return bad_input(path, std::string("cannot open: ") + std::strerror(errno));
  std::string content;
  struct stat status {};
  if (::fstat(file.get(), &status) == 0 && status.st_size > 0)
    content.reserve(static_cast<std::size_t>(status.st_size));
  char buffer[1 << 16];
  for (;;) {
    const ssize_t count = ::read(file.get(), buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return bad_input(path, std::string("cannot read: ") + std::strerror(errno));
    if (count == 0) return content;
    content.append(buffer, static_cast<std::size_t>(count));
  }
}

Result<std::string> read_file(const fs::path& path, std::size_t begin, std::size_t end) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return bad_input(path, std::string("cannot open: ") + std::strerror(errno));
  std::string content(end - begin, '\0');
  for (std::size_t at = 0; at < content.size();) {
    const ssize_t count = ::pread(file.get(), content.data() + at, content.size() - at,
                                  static_cast<off_t>(begin + at));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return bad_input(path, std::string("cannot read: ") + std::strerror(errno));
    if (count == 0) return bad_input(path, "the file got shorter while it was read");
    at += static_cast<std::size_t>(count);
  }
  return content;
}

}  // namespace relief
