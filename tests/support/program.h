#pragma once

#include <csignal>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace relief::testing {

/// What a finished run of the program `relief` left behind.
struct ProgramRun {
  int exit_status = -1;  ///< 128 + signal number when a signal ended it.
  std::string standard_output;
  std::string standard_error;
};

struct ProgramLimits {
  long file_size_bytes = -1;  ///< Largest file it may write; writing more fails as on a full disk.
  /// Stands for /sys/fs/cgroup, where it is not empty. That takes the rights to mount: without them
  /// the exit status is kNotPermitted.
  std::filesystem::path control_groups = {};
  static constexpr int kNotPermitted = 126;
};

/// Runs the program under test with `arguments` and waits for it.
ProgramRun run_relief(const std::vector<std::string>& arguments, const ProgramLimits& limits = {});

/// Runs it until it ends or `enough()` is true, which is asked all the time: the program then gets
/// `signal`.
ProgramRun run_relief_until(const std::function<bool()>& enough,
                            const std::vector<std::string>& arguments, int signal = SIGKILL);

/// Names of all files below `folder`, relative to it, sorted.
std::vector<std::string> files_below(const std::filesystem::path& folder);

void write_text(const std::filesystem::path& path, const std::string& text);
std::string read_text(const std::filesystem::path& path);

}  // namespace relief::testing
