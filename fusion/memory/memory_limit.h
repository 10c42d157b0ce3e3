#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>

#include "relief/scan/result.h"

namespace relief::fusion {

/// Keeps a computation below a limit of memory. Large arrays made under a limit (PagedArray) lie in
/// temporary files that are mapped to memory. Work on them goes brick by brick; between bricks
/// evict_pages() looks at how much memory the process has, and near the limit hands all pages of
/// these files back to the system; the next access fetches them again. So a limit changes where
/// numbers lie and never what they are.
///
/// The files have no name: nothing of them is left whichever way the process ends. May be used from
/// any thread; must outlive the arrays made under it. Where functions take a pointer to a limit,
/// null means none.
class MemoryLimit {
 public:
  /// `limit`: resident memory of the whole process [bytes]. `folder`: where the files are made, a
  /// disk best; empty: TMPDIR, or /tmp. `resident` tells the memory the process has; other than the
  /// default for tests only.
  explicit MemoryLimit(std::size_t limit, std::filesystem::path folder = {},
                       std::function<std::size_t()> resident = {});
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

  /// Whether `needed` [bytes] can be had without handing pages back.
  bool has_room(std::size_t needed) const { return resident_() + needed <= limit_; }

  /// Whether one more large array of `bytes` may lie in memory. All such arrays together have an
  /// eighth of the limit, with all that the process has now: so a limit that is ample costs
  /// nothing, and a tight one nearly all of them lie in files.
  bool keep_in_memory(std::size_t bytes);

  /// Makes room for `needed` [bytes] that are about to be allocated; the default serves the work on
  /// a brick.
  void evict_pages(std::size_t needed = kBrickBytes);

  /// The first of what went wrong so far: kUnsolvable when the limit could not be kept, the message
  /// telling what is needed; kCannotWrite when no file could be made.
  Result<void> check() const;

  /// Whether the files are themselves in memory (a tmpfs), where they spare the system nothing.
  bool folder_is_memory() const;

  const std::filesystem::path& folder() const { return folder_; }
  std::size_t releases() const;  ///< How often pages were handed back.

  /// A zeroed block in a file of its own; null when that cannot be made, which check() tells.
  void* map(std::size_t bytes);
  void unmap(void* address);

 private:
  static constexpr std::size_t kBrickBytes = std::size_t{16} << 20;  // Changes no result.

  void* map_file(int file, std::size_t bytes);
  void fail(ErrorKind kind, const std::string& message);

  std::size_t limit_;
  std::filesystem::path folder_;
  std::function<std::size_t()> resident_;
  mutable std::mutex mutex_;
  std::map<void*, std::size_t> blocks_;
  std::size_t releases_ = 0;
  std::size_t in_memory_ = 0;  // Of the arrays that keep_in_memory() allowed.
  std::optional<Error> failure_;
};

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

}  // namespace relief::fusion
