#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "apps/reports/report.h"
#include "reconstruction/cache/folder_lock.h"
#include "relief/reconstruction/unit_folder.h"
#include "relief/scan/result.h"

namespace relief {

struct CacheFlags {
  reconstruction::UnitFolderOptions options;
};

/// Adds --cache-limit and --fresh.
void add_cache_options(CLI::App& command, CacheFlags& flags);

/// The output folder of a run: held for it alone, with the results of earlier runs in it. Or that
/// of steps, several at a time.
class RunCache {
 public:
  /// The error of the lock; a cache that cannot be opened is a warning, and the run goes without.
  Result<void> open(const std::filesystem::path& output, const CacheFlags& flags);

  /// The same for a step, which hands on its results here alone: a cache that cannot be opened is
  /// an error. Steps remove nothing, since others may need it: the limit is that of runs.
  Result<void> open_for_step(const std::filesystem::path& output, const CacheFlags& flags);

  /// Null where nothing is to be kept.
  UnitStore* store() const { return units_.get(); }

  /// Logs how many units of a kind, called `what`, earlier runs left, and what the store warns of.
  void log(const std::string& kind, const std::string& what);

  /// Logs what a run that ends early leaves for the next one.
  void log_kept();

  /// By kind: units found and computed.
  Json report() const;
  reconstruction::UnitCounts sum() const;  ///< Of all kinds.

  /// Error: kCannotWrite, where a result could not be kept that a later step needs.
  Result<void> all_kept();

 private:
  Result<void> lock(const std::filesystem::path& output, reconstruction::FolderUse use);
  void log_warnings();

  std::optional<reconstruction::FolderLock> lock_;
  std::unique_ptr<reconstruction::UnitFolder> units_;
};

}  // namespace relief
