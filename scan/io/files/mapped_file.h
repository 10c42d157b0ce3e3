#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <utility>

#include "relief/scan/result.h"

namespace relief {

/// The bytes of a file, of which the system holds in memory only what is read.
class MappedFile {
 public:
  /// kBadInput when it cannot be read.
  static Result<MappedFile> open(const std::filesystem::path& path);

  MappedFile(MappedFile&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  MappedFile& operator=(MappedFile&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~MappedFile();

  /// Lasts as long as this. A program that shortens the file meanwhile ends this one (SIGBUS).
  std::string_view content() const { return {data_, size_}; }
  /// Lets the system have the memory of the first `end` bytes back. They can still be read.
  void release_before(std::size_t end) const;

 private:
  MappedFile() = default;

  const char* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace relief
