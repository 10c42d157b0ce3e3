#pragma once

#include <filesystem>
#include <string>

#include "relief/scan/result.h"

namespace relief::reconstruction {

/// The folder in an output folder that runs keep for themselves: `.relief`.
std::filesystem::path private_folder(const std::filesystem::path& output);

/// Holds an output folder for one process, until the object or the process ends, however that ends:
/// a lock of the operating system on `.relief/lock`, which tells others who holds it.
class FolderLock {
 public:
  /// Locks `output`, an existing folder, and creates `.relief` in it. Unfinished files of a run
  /// that was killed here are removed. Errors: kCannotWrite when another process holds the folder
  /// (the message names it) or when the lock cannot be created.
  static Result<FolderLock> acquire(const std::filesystem::path& output);

  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

  /// False where the file system knows no locks: nobody else is kept out.
  bool held() const { return held_; }

 private:
  FolderLock(int descriptor, bool held) : descriptor_(descriptor), held_(held) {}

  int descriptor_;
  bool held_;
};

}  // namespace relief::reconstruction
