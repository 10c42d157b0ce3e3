#pragma once

#include <filesystem>

#include <CLI/CLI.hpp>

#include "apps/reports/report.h"

namespace relief {

/// The section `run` of the report: `input`, and `options`, those that `command` was given with
/// their values, by their long names.
Json run_record(const std::filesystem::path& input, const CLI::App& command);

}  // namespace relief
