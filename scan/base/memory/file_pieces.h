#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <vector>

namespace relief {

/// Short blocks in files that hold many of them: a file for each would be thousands of files and
/// mappings. A file has blocks of the same number of pages and lasts as long as the object. Not to
/// be used by several threads at a time.
class FilePieces {
 public:
  /// Blocks of more than this have files of their own [bytes].
  static constexpr std::size_t kLargest = std::size_t{1} << 16;

  /// `map` makes a zeroed file of a size [bytes] and maps it to memory; null where it cannot.
  explicit FilePieces(std::function<void*(std::size_t)> map) : map_(std::move(map)) {}

  /// A zeroed block of `bytes`, at most kLargest; null when no file can be made.
  void* take(std::size_t bytes);
  /// The end of a block of `bytes`, for others to take. False: it is none of these.
  bool give_back(void* address, std::size_t bytes);

 private:
  static constexpr std::size_t kPage = 4096;
  static constexpr std::size_t kPiecesOfFile = 64;

  static std::size_t pages_of(std::size_t bytes) { return (bytes + kPage - 1) / kPage; }

  struct SameSize {
    char* next = nullptr;  // Of those that nobody had yet.
    std::size_t left = 0;
    std::vector<void*> free;
  };
  std::function<void*(std::size_t)> map_;
  std::array<SameSize, kLargest / kPage + 1> of_pages_;
  std::map<const char*, std::size_t> files_;  // Their beginnings and sizes [bytes].
};

}  // namespace relief
