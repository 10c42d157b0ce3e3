#pragma once

#include <filesystem>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/reports/report.h"
#include "relief/scan/range_view.h"

namespace relief {

/// The section `run` of the report: `input`, `program`, which names the build, and `options` by
/// their long names: those that `command` was given with their values, and of all that take one of
/// some words the word, given or by default.
Json run_record(const std::filesystem::path& input, const CLI::App& command);

/// For each view its `name`, `samples_sha256`, the hash of what it measured, and `pose_sha256`,
/// that of the pose it starts from. Two runs that have the same hashes had the same inputs.
Json input_record(const std::vector<RangeView>& views);

}  // namespace relief
