#include "apps/options/memory_option.h"

#include <map>

#include "relief/scan/context.h"
#include "scan/base/system/control_groups.h"

namespace relief {

void add_memory_option(CLI::App& command, MemoryFlag& flag, const std::string& what) {
  command
      .add_option(
          "--memory", flag.mebibytes,
          "Memory to keep to, as 4G or 800M; a number alone is in MiB: " + what + "; 0: no limit")
      ->transform(CLI::AsNumberWithUnit(
          std::map<std::string, std::size_t>{{"M", 1}, {"G", 1 << 10}, {"T", 1 << 20}}))
      ->default_str("what the control group leaves, if it has a limit");
}

std::size_t MemoryFlag::bytes(const std::filesystem::path& root) const {
  // A tenth is for what is not resident: page tables, and pages of files not yet written.
  constexpr double kShare = 0.9;
  if (mebibytes) return *mebibytes << 20;
  return static_cast<std::size_t>(kShare * static_cast<double>(memory_in_groups(root)));
}

int work_within(const MemoryFlag& memory, const std::filesystem::path& folder,
                const std::function<int()>& work) {
  Context context;
  context.memory = memory.bytes();
  context.temporary_folder = std::filesystem::current_path() / folder;
  while (!std::filesystem::is_directory(context.temporary_folder) &&
         context.temporary_folder.has_relative_path())
    context.temporary_folder = context.temporary_folder.parent_path();
  int status = 0;
  run_until_stopped(context, [&] { status = work(); });
  return status;
}

}  // namespace relief
