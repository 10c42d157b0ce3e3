#pragma once

#include <utility>

#include <unistd.h>

namespace relief {

/// Closes a descriptor on every way out.
class FileDescriptor {
 public:
  /// Takes what open() returned; -1 is no open file.
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() { close(); }

  bool is_open() const { return descriptor_ >= 0; }
  int get() const { return descriptor_; }

  /// False where the system reports an error, with `errno`: a write may be lost. Harmless twice.
  bool close() {
    const int descriptor = std::exchange(descriptor_, -1);
    return descriptor < 0 || ::close(descriptor) == 0;
  }

 private:
  int descriptor_;
};

}  // namespace relief
