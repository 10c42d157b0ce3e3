#include <cstdio>
#include <memory>
#include <string>
#include <system_error>

#include "apps/commands/command.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "reconstruction/cache/folder_lock.h"
#include "relief/reconstruction/unit_folder.h"

namespace relief {

namespace {

namespace fs = std::filesystem;

struct CleanCommand {
  bool quiet = false;
  fs::path folder;
};

std::string in_megabytes(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) / 1e6);
  return text;
}

// The lock is held until the folder has gone, so that no run writes into it meanwhile.
int clean(const CleanCommand& command) {
  const fs::path kept = reconstruction::private_folder(command.folder);
  std::error_code failure;
  if (!fs::exists(kept, failure)) {
    Console::info(command.folder.string() + ": no run has left anything to remove");
    return kDone;
  }
  const auto lock = reconstruction::FolderLock::acquire(command.folder);
  if (!lock) return fail(lock.error());
  std::size_t files = 0;
  std::uint64_t bytes = 0;
  {
    const auto units = reconstruction::UnitFolder::open(kept / "cache");
    if (!units) return fail(units.error());
    files = (*units)->files();
    bytes = (*units)->bytes();
  }
  fs::remove_all(kept, failure);
  if (failure)
    return fail({ErrorKind::kCannotWrite, kept.string() + ": cannot remove: " + failure.message()});
  Console::info(kept.string() + ": removed " + std::to_string(files) +
                " results of earlier runs, " + in_megabytes(bytes));
  return kDone;
}

}  // namespace

void add_clean(CLI::App& app, Action& action) {
  auto command = std::make_shared<CleanCommand>();
  auto* sub = app.add_subcommand("clean", "Remove what `run` keeps in its folder for later runs");
  sub->add_option("folder", command->folder, "Output folder of `relief run`")
      ->required()
      ->check(CLI::ExistingDirectory);
  sub->add_flag("-q,--quiet", command->quiet, "Only errors on standard error");
  sub->callback([command, &action] {
    if (command->quiet) Console::set_verbosity(Verbosity::kQuiet);
    action = [command] { return clean(*command); };
  });
}

}  // namespace relief
