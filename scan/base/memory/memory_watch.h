#pragma once

#include <thread>

namespace relief {

class MemoryLimit;

/// Keeps a limit from a thread of its own, as long as this object lives. Loops that read pages all
/// over large files bring hundreds of MB between two looks of their own at the memory.
class MemoryWatch {
 public:
  /// `limit` must outlive this object.
  explicit MemoryWatch(MemoryLimit& limit);

 private:
  std::jthread thread_;
};

}  // namespace relief
