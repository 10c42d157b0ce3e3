#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "relief/io/project_io.h"
#include "relief/scan/result.h"

namespace relief {

/// How many metres a unit of that name is. Unknown units count as metres: a file of metres has no
/// other way to hold them.
double metres_in(const std::string& unit);

/// Whether export_views() knows the ending of `path`.
bool is_export_path(const std::filesystem::path& path);

/// Writes the views of `project`, or their poses, for other programs, by the ending of `path`:
/// - views with poses: `.e57` (metres), `.ptx`, and `.pcd` for one view alone;
/// - poses: `.aln` and `.conf`, which name the grid files of `source`, from which `project` was
///   read, and `.mlp`, `.log`, `.tum`;
/// - one mesh of all views: the endings of write_mesh().
/// kBadInput where the format cannot hold the project; the message says what to do.
Result<void> export_views(const ScanProject& project, const std::filesystem::path& source,
                          const ReadProjectOptions& source_options,
                          const std::filesystem::path& path);

/// Adds `--export FILE`, which may be given several times. Endings are checked at once.
void add_export_option(CLI::App& command, std::vector<std::filesystem::path>& files);

/// What export_all() refuses, to be told before any work: kBadInput where a format cannot hold the
/// project.
Result<void> check_exports(const ScanProject& project, const std::filesystem::path& source,
                           const ReadProjectOptions& source_options,
                           const std::vector<std::filesystem::path>& files);
/// The same for views that write_project() is going to write as they are by default.
Result<void> check_exports_of_results(const std::vector<RangeView>& views,
                                      const std::vector<std::filesystem::path>& files);

/// Writes every file of `--export`, and says so.
Result<void> export_all(const ScanProject& project, const std::filesystem::path& source,
                        const ReadProjectOptions& source_options,
                        const std::vector<std::filesystem::path>& files);

}  // namespace relief
