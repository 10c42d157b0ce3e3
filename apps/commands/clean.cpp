#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>

#include "apps/commands/command.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/reports/report.h"
#include "reconstruction/cache/folder_lock.h"
#include "relief/reconstruction/unit_folder.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

struct CleanCommand {
  CommonOptions common;
  fs::path folder;
};

struct Removed {
  std::size_t files = 0;
  std::uint64_t bytes = 0;
};

std::string in_megabytes(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) / 1e6);
  return text;
}

Result<Removed> count_kept(const fs::path& kept) {
  const auto units = reconstruction::UnitFolder::open(kept / "cache");
  if (!units) return units.error();
  return Removed{(*units)->files(), (*units)->bytes()};
}

// The lock is held until the folder has gone, so that no run writes into it meanwhile.
Result<Removed> remove_kept(const fs::path& folder) {
  const fs::path kept = reconstruction::private_folder(folder);
  std::error_code failure;
  if (!fs::exists(kept, failure)) {
    Console::info(folder.string() + ": no run has left anything to remove");
    return Removed{};
  }
  const auto lock = reconstruction::FolderLock::acquire(folder);
  if (!lock) return lock.error();
  const auto removed = count_kept(kept);
  if (!removed) return removed;
  fs::remove_all(kept, failure);
  if (failure)
    return Error{ErrorKind::kCannotWrite, kept.string() + ": cannot remove: " + failure.message()};
  Console::info(kept.string() + ": removed " + std::to_string(removed->files) +
                " results of earlier runs, " + in_megabytes(removed->bytes));
  return removed;
}

int clean(const CleanCommand& command) {
  const auto removed = remove_kept(command.folder);
  if (!removed) return fail(removed.error());
  const Json figures = {{"files", removed->files}, {"bytes", removed->bytes}};
  const auto delivered = report_on_request("clean", figures, command.common);
  return delivered ? kDone : fail(delivered.error());
}

}  // namespace

void add_clean(CLI::App& app, Action& action) {
  auto command = std::make_shared<CleanCommand>();
  auto* sub = app.add_subcommand("clean", "Remove what `run` keeps in its folder for later runs");
  sub->add_option("folder", command->folder, "Output folder of `relief run`")
      ->required()
      ->check(CLI::ExistingDirectory);
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return clean(*command); }; });
}

}  // namespace relief
