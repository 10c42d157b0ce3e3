#pragma once

#include <filesystem>
#include <string>

#include "relief/scan/result.h"

namespace relief {

/// kBadInput: `file`: `what`, where `what` names the place in the file and the remedy.
inline Error bad_input(const std::filesystem::path& file, const std::string& what) {
  return {ErrorKind::kBadInput, file.string() + ": " + what};
}

/// kCannotWrite: `file`: `what`.
inline Error cannot_write(const std::filesystem::path& file, const std::string& what) {
  return {ErrorKind::kCannotWrite, file.string() + ": " + what};
}

}  // namespace relief
