#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "relief/scan/result.h"
#include "scan/base/memory/file_pieces.h"

namespace relief {

/// Smaller arrays lie in memory also under a limit [bytes].
inline constexpr std::size_t kSmallArray = std::size_t{1} << 12;

/// Keeps a computation below a limit of memory. Large arrays made under a limit (PagedArray, Grid)
/// lie in temporary files that are mapped to memory. Near the limit evict_pages() hands all pages
/// of these files back to the system; the next access fetches them again. Work on fields calls it
/// between bricks, and loops (parallel.h) call evict_in_time(). So a limit changes where numbers
/// lie and never what they are.
///
/// The files have no name: nothing of them is left whichever way the process ends. May be used from
/// any thread; must outlive the arrays made under it. Where functions take a pointer to a limit,
/// null means none.
class MemoryLimit : public std::enable_shared_from_this<MemoryLimit> {
 public:
  /// `limit`: resident memory of the whole process [bytes]. `folder`: where the files are made, a
  /// disk best; empty: TMPDIR, or /tmp. `resident` tells the memory the process has; other than the
  /// default for tests only.
  explicit MemoryLimit(std::size_t limit, std::filesystem::path folder = {},
                       std::function<std::size_t()> resident = {});
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

  std::size_t bytes() const { return limit_; }

  /// What arrays and grids may have in memory at most, all together [bytes].
  std::size_t most_in_memory() const { return limit_ / kAmple; }

  /// Whether `needed` [bytes] can be had without handing pages back.
  bool has_room(std::size_t needed) const { return resident_() + needed <= limit_; }

  /// What loops may still fetch before their pages are handed back [bytes].
  std::size_t room_for_loops() const;
  /// Whether handing pages back leaves loops room.
  bool can_make_room_for_loops() const;

  /// Whether one more large array of `bytes` may lie in memory. All such arrays together have an
  /// eighth of the limit, with all that the process has now: so a limit that is ample costs
  /// nothing, and a tight one nearly all of them lie in files.
  bool keep_in_memory(std::size_t bytes);

  /// Makes room for `needed` [bytes] that are about to be allocated; the default serves the work on
  /// a brick.
  void evict_pages(std::size_t needed = kBrickBytes);

  /// The same for loops: looks now and then only, and a limit that cannot be kept is no failure.
  void evict_in_time(std::size_t needed = 0);

  /// Hands all pages back, and tells what the process has then [bytes].
  std::size_t evict();

  /// The first of what went wrong so far: kUnsolvable when the limit could not be kept, the message
  /// telling what is needed; kCannotWrite when no file could be made.
  Result<void> check() const;

  /// Whether the files are themselves in memory (a tmpfs), where they spare the system nothing.
  bool folder_is_memory() const;

  const std::filesystem::path& folder() const { return folder_; }
  std::size_t releases() const;  ///< How often pages were handed back.

  /// A zeroed block in a file, a short one with others; null when the file cannot be made, which
  /// check() tells.
  void* map(std::size_t bytes);
  /// The end of an array of `bytes`. True: it lay in a file, which is gone. False: it lies in
  /// memory, where others have room for it now.
  bool release(void* address, std::size_t bytes);

  /// Memory of a grid, not zeroed: on the heap where it is small, where all grids there have no
  /// more than an eighth of the limit, or where no file can be made; else in a file. Throws
  /// std::bad_alloc.
  void* allocate(std::size_t bytes);
  void deallocate(void* address, std::size_t bytes);

 private:
  // The part of a limit up to which arrays lie in memory. Takes at most so much from what the rest
  // of the work may need, which no file can hold. Changes no result.
  static constexpr std::size_t kAmple = 8;
  // What the work on a brick takes, and what loops take between two looks. A page that is touched
  // brings 15 others, so loops over files take up to 30 MB a millisecond. Change no result.
  static constexpr std::size_t kBrickBytes = std::size_t{16} << 20;
  static constexpr std::size_t kLoopBytes = std::size_t{40} << 20;
  static constexpr std::size_t kMostLoopBytes = std::size_t{128} << 20;
  static constexpr std::size_t kLoopPart = 10;  // Of the limit, if that is between the two.

  std::size_t touched_at_once() const;
  bool keep_grid_in_memory(std::size_t bytes);
  std::size_t evict_all();
  // A file without a name, mapped to memory.
  struct MappedFile {
    void* address;  // Null: there is none, `code` tells why (errno).
    std::size_t bytes;
    int code;
  };
  MappedFile new_file(std::size_t bytes) const;
  void* keep(const MappedFile& file);
  void fail(ErrorKind kind, const std::string& message);

  std::size_t limit_;
  std::filesystem::path folder_;
  std::function<std::size_t()> resident_;
  mutable std::mutex mutex_;
  std::map<void*, std::size_t> files_;  // Where they are mapped, and their sizes.
  FilePieces pieces_{[this](std::size_t bytes) { return keep(new_file(bytes)); }};
  std::size_t releases_ = 0;
  std::size_t in_memory_ = 0;  // Of the arrays and grids that may lie there.
  // Of evict_in_time(), on the steady clock [ns]: later where evicting did not help.
  std::atomic<std::int64_t> next_look_{0}, next_eviction_{0};
  std::atomic<bool> evicting_{false};
  std::optional<Error> failure_;
};

/// The limit of the enclosing run_in() whose context has one; null: there is none.
MemoryLimit* current_memory_limit();

/// Resident memory of the process without what current_memory_limit() keeps in files [bytes].
std::size_t resident_beyond_files();

/// Evicts the pages of `limit` as MemoryLimit::evict_pages() does; nothing when there is no limit.
inline void evict_pages(MemoryLimit* limit) {
  if (limit) limit->evict_pages();
}
inline void evict_pages(MemoryLimit* limit, std::size_t needed) {
  if (limit) limit->evict_pages(needed);
}
inline Result<void> check(const MemoryLimit* limit) {
  return limit ? limit->check() : Result<void>();
}
/// Both: an error, before they are taken, when there is no room for `needed` [bytes].
inline Result<void> make_room(MemoryLimit* limit, std::size_t needed) {
  evict_pages(limit, needed);
  return check(limit);
}

}  // namespace relief
