#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "relief/scan/result.h"
#include "relief/scan/unit_store.h"

namespace relief::reconstruction {

struct UnitFolderOptions {
  /// What all files together may take [bytes], > 0. Units that no run has used for longest go
  /// first. Those of this run stay: what finds no room beside them is not kept.
  std::uint64_t limit = std::uint64_t{4} << 30;
  bool fresh = false;  ///< Find nothing. What is computed takes the place of what was kept.
};

/// How many units of a kind were taken from the folder, and how many were computed.
struct UnitCounts {
  std::size_t found = 0, computed = 0;
};

/// Units of work as files of a folder, docs/cache.md: `HH/HASH` with the first two digits of the
/// hash. A file begins with a line that holds key, length and checksum; it is believed only if all
/// agree with its content, and is written beside its place and renamed.
class UnitFolder : public UnitStore {
 public:
  /// Creates the folder if need be. Error: kCannotWrite.
  static Result<std::unique_ptr<UnitFolder>> open(const std::filesystem::path& folder,
                                                  const UnitFolderOptions& options = {});

  std::optional<std::string> find(const UnitKey& key) override;
  void keep(const UnitKey& key, std::string_view content) override;

  /// By kind, since the folder was opened.
  std::map<std::string, UnitCounts> counts() const;
  /// What the user should know since the last call, one line each: damaged files, no room.
  std::vector<std::string> take_warnings();
  /// How many results could not be kept.
  std::size_t not_kept() const;
  std::size_t files() const;
  std::uint64_t bytes() const;

 private:
  struct File {
    std::uint64_t bytes = 0;
    std::filesystem::file_time_type used;
    bool of_this_run = false;
  };

  UnitFolder(std::filesystem::path folder, const UnitFolderOptions& options)
      : folder_(std::move(folder)), options_(options) {}

  void take_stock();
  std::filesystem::path path_of(const std::string& hash) const;
  bool make_room(const std::string& hash, std::uint64_t bytes);
  void forget(const std::string& hash);
  void give_back_room(const std::string& hash);
  void warn_once(const std::string& topic, const std::string& warning);
  std::optional<std::string> read(const UnitKey& key);
  Result<void> write(const std::string& hash, const std::string& head, std::string_view content);
  Result<void> write_or_forget(const std::string& hash, const std::string& head,
                               std::string_view content);

  const std::filesystem::path folder_;
  const UnitFolderOptions options_;
  mutable std::mutex mutex_;  // Of all below; never held while a file is read or written.
  std::map<std::string, File> files_;
  std::uint64_t bytes_ = 0;
  std::map<std::string, UnitCounts> counts_;
  std::map<std::string, bool> warned_;
  std::vector<std::string> warnings_;
  std::size_t written_ = 0, not_kept_ = 0;
};

}  // namespace relief::reconstruction
