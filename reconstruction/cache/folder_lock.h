#pragma once

#include <filesystem>
#include <string>

#include "relief/scan/result.h"

namespace relief::reconstruction {

/// The folder in an output folder that runs keep for themselves: `.relief`.
std::filesystem::path private_folder(const std::filesystem::path& output);

/// Who may work in an output folder at the same time.
enum class FolderUse {
  kAlone,   ///< A run: nobody else.
  kShared,  ///< A step, which only reads and writes units: other steps, but no run.
};

/// Holds an output folder for one process, or for several steps, until the object or the process
/// ends, however that ends: a lock of the operating system on `.relief/lock`, which tells others
/// who holds it.
class FolderLock {
 public:
  /// Locks `output`, an existing folder, and creates `.relief` in it. Unfinished files of a process
  /// that was killed here are removed, those of steps only by a run. Errors: kCannotWrite when
  /// others hold the folder (the message names a run, or the step that came last) or when the lock
  /// cannot be created.
  static Result<FolderLock> acquire(const std::filesystem::path& output,
                                    FolderUse use = FolderUse::kAlone);

  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

  /// False where the file system knows no locks: nobody else is kept out.
  bool held() const { return held_; }

 private:
  FolderLock(int descriptor, bool held, FolderUse use)
      : descriptor_(descriptor), held_(held), use_(use) {}

  int descriptor_;
  bool held_;
  FolderUse use_;
};

}  // namespace relief::reconstruction
