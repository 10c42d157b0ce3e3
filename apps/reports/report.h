#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "apps/commands/command.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief {

/// Machine-readable figures; keys keep the order in which they were set.
using Json = nlohmann::ordered_json;

/// Row-major 4x4 nested arrays, as in scan.json.
Json to_json(const RigidMotion& motion);

/// Where the report of a command goes: --report, or report.json in the folder of the output.
std::filesystem::path report_path(const CommonOptions& common, const std::filesystem::path& output);

/// Writes `section` under `name` into the report at `path`, keeping the sections of other commands
/// that it holds already, and prints the whole report to standard output if asked.
Result<void> write_report(const std::filesystem::path& path, const std::string& name,
                          const Json& section, const CommonOptions& common);

/// For commands without a folder of results: with --json prints `section` under `name` alone, with
/// --report adds it to that report.
Result<void> report_on_request(const std::string& name, const Json& section,
                               const CommonOptions& common);

/// The largest resident memory of this process so far [MB].
double peak_memory_mb();

}  // namespace relief
