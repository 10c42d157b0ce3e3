#pragma once

#include <filesystem>
#include <vector>

#include "apps/commands/command.h"
#include "relief/scan/result.h"

namespace relief {

/// What a command is going to write.
struct Outputs {
  std::filesystem::path folder;              ///< Of a project with all views; empty: none.
  std::vector<std::filesystem::path> files;  ///< Besides.
};

/// Nothing is written over what is read: kBadInput that names a file that is both, or the folder
/// that the scans and their results would share. Links to a file or folder are the same as it. Also
/// the errors of read_project_spec(). Reads no data of views.
Result<void> check_outputs(const ProjectInput& input, const Outputs& outputs);

/// The same for a command that reads one file and writes another.
Result<void> check_output(const std::filesystem::path& input, const std::filesystem::path& output);

}  // namespace relief
