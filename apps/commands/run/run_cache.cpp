#include "apps/commands/run/run_cache.h"

#include <limits>
#include <utility>

#include "apps/console/console.h"

namespace relief {

namespace {

constexpr double kMebibyte = 1 << 20;

}  // namespace

void add_cache_options(CLI::App& command, CacheFlags& flags) {
  auto* group = command.add_option_group("Cache");
  group
      ->add_option("--cache-limit", flags.options.limit,
                   "What DIR/.relief may take, as 500M or 20G, so that another run of this folder "
                   "computes only what is new; 0: keep nothing")
      ->transform(CLI::AsSizeValue(false))
      ->default_str("4G");
  group->add_flag("--fresh", flags.options.fresh,
                  "Compute everything, whatever earlier runs of this folder have left");
}

Result<void> RunCache::lock(const std::filesystem::path& output, reconstruction::FolderUse use) {
  auto lock = reconstruction::FolderLock::acquire(output, use);
  if (!lock) return lock.error();
  if (!lock->held())
    Console::warning(output.string() +
                     ": this file system has no locks: start no run in this folder while another "
                     "run or a step works there");
  lock_.emplace(std::move(*lock));
  return {};
}

Result<void> RunCache::open(const std::filesystem::path& output, const CacheFlags& flags) {
  if (auto locked = lock(output, reconstruction::FolderUse::kAlone); !locked) return locked;
  if (flags.options.limit == 0) return {};
  const auto folder = reconstruction::private_folder(output) / "cache";
  auto units = reconstruction::UnitFolder::open(folder, flags.options);
  if (units)
    units_ = std::move(*units);
  else
    Console::warning(units.error().message + "; the run goes on and keeps no results");
  return {};
}

Result<void> RunCache::open_for_step(const std::filesystem::path& output, const CacheFlags& flags) {
  if (flags.options.limit == 0)
    return Error{ErrorKind::kBadInput,
                 "a step hands its results on in DIR/.relief: leave out --cache-limit 0"};
  if (auto locked = lock(output, reconstruction::FolderUse::kShared); !locked) return locked;
  reconstruction::UnitFolderOptions options = flags.options;
  options.limit = std::numeric_limits<std::uint64_t>::max();
  auto units =
      reconstruction::UnitFolder::open(reconstruction::private_folder(output) / "cache", options);
  if (!units) return units.error();
  units_ = std::move(*units);
  return {};
}

void RunCache::log(const std::string& kind, const std::string& what) {
  if (!units_) return;
  log_warnings();
  const auto [found, computed] = units_->counts()[kind];
  if (found == 0) return;
  if (found + computed == 1)
    Console::info("the " + what + " is that of an earlier run");
  else
    Console::info(std::to_string(found) + " of " + std::to_string(found + computed) + " " + what +
                  " from an earlier run");
}

void RunCache::log_warnings() {
  for (const std::string& warning : units_->take_warnings()) Console::warning(warning);
}

void RunCache::log_kept() {
  if (!units_) return;
  log_warnings();
  if (units_->files() == 0) return;
  char size[32];
  std::snprintf(size, sizeof size, "%.0f MB", static_cast<double>(units_->bytes()) / kMebibyte);
  Console::info("kept " + std::to_string(units_->files()) + " finished results (" + size +
                "): the same command goes on from there");
}

Json RunCache::report() const {
  Json kinds = Json::object();
  if (units_)
    for (const auto& [kind, counts] : units_->counts())
      kinds[kind] = {{"found", counts.found}, {"computed", counts.computed}};
  return kinds;
}

reconstruction::UnitCounts RunCache::sum() const {
  reconstruction::UnitCounts sum;
  if (!units_) return sum;
  for (const auto& [kind, counts] : units_->counts()) {
    sum.found += counts.found;
    sum.computed += counts.computed;
  }
  return sum;
}

Result<void> RunCache::all_kept() {
  log_warnings();
  if (units_->not_kept() == 0) return {};
  return Error{ErrorKind::kCannotWrite,
               std::to_string(units_->not_kept()) +
                   " finished results could not be kept for the steps that need them: make room, "
                   "and give the same command again"};
}

}  // namespace relief
