#pragma once

#include <filesystem>

#include <CLI/CLI.hpp>

#include "relief/scan/result.h"

namespace relief {

/// Creates `folder` and what is above it, so that a long computation does not end at an unwritable
/// output.
Result<void> prepare_folder(const std::filesystem::path& folder);
/// The same for the folder of a file.
Result<void> prepare_folder_of(const std::filesystem::path& file);

/// Accepts file names whose ending write_mesh knows.
CLI::Validator known_mesh_ending();

}  // namespace relief
