#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/console/progress_format.h"
#include "relief/io/project_io.h"
#include "relief/scan/context.h"

namespace relief {

/// Options that every command has.
struct CommonOptions {
  bool quiet = false;
  bool verbose = false;
  ProgressFormat progress = ProgressFormat::kAuto;
  bool json = false;  ///< Print the report to standard output.
  int threads = 0;    ///< 0: one per core.
  std::uint64_t seed = 1;
  std::filesystem::path report;  ///< Empty: report.json beside the output.
};

/// What a chosen command does after parsing: returns the exit status.
using Action = std::function<int()>;

/// Adds one command to `app`; when the command line chooses it, `action` is set.
using AddCommand = void (*)(CLI::App& app, Action& action);

void add_info(CLI::App& app, Action& action);
void add_align(CLI::App& app, Action& action);
void add_calibrate(CLI::App& app, Action& action);
void add_refine(CLI::App& app, Action& action);
void add_merge(CLI::App& app, Action& action);
void add_run(CLI::App& app, Action& action);
void add_step(CLI::App& app, Action& action);
void add_plan(CLI::App& app, Action& action);
void add_simulate(CLI::App& app, Action& action);
void add_evaluate(CLI::App& app, Action& action);
void add_compare(CLI::App& app, Action& action);
void add_convert(CLI::App& app, Action& action);
void add_init(CLI::App& app, Action& action);
void add_render(CLI::App& app, Action& action);
void add_report(CLI::App& app, Action& action);
void add_clean(CLI::App& app, Action& action);

/// Adds -q, -v, --progress, --json, --threads, --seed and --report to a command.
void add_common_options(CLI::App& command, CommonOptions& options);

/// The input project of a command and how to read it.
struct ProjectInput {
  std::filesystem::path path;
  ReadProjectOptions options;
  bool look_for_background = false;  ///< Whether the command works on the object alone.
  bool keep_background = false;      ///< Name what is found, but leave it in.
};

/// Adds the options that say how a project without a scan.json is read: --fc, --intrinsics,
/// --depth-scale, --viewpoint and --ignore-viewpoint.
void add_reading_options(CLI::App& command, ReadProjectOptions& options);

/// Adds the positional PROJECT and the options above.
void add_project_input(CLI::App& command, ProjectInput& input);

/// Adds --background to a command that works on the object alone.
void add_background_option(CLI::App& command, ProjectInput& input);

/// Gets the views as they were read, before a background is left out.
using ViewsRead = std::function<void(const std::vector<RangeView>& views)>;

/// Reads the project with progress, and logs what the reader found out by itself.
Result<ScanProject> read_with_notes(const ProjectInput& input, const CommonOptions& common,
                                    const ViewsRead& views_read = {});

/// The context of one stage of a command. Threads are those of the whole command already.
Context context_of(const CommonOptions& common, const std::string& stage);

/// Logs the error and gives its exit status.
int fail(const Error& error);

}  // namespace relief
