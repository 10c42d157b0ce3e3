#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "relief/hybrid/refine_view.h"
#include "relief/reconstruction/build_model.h"
#include "relief/registration/align_views.h"
#include "relief/registration/calibrate_views.h"

namespace relief {

/// Memory of the whole process.
struct MemoryFlag {
  /// 0: no limit. Not given: what control groups leave (a container, a batch job), if they do.
  std::optional<std::size_t> mebibytes;

  /// The limit now, 0: none. `root`: see memory_in_groups().
  std::size_t bytes(const std::filesystem::path& root = "/") const;
};
/// `what`: what is done to keep to the limit.
void add_memory_option(CLI::App& command, MemoryFlag& flag, const std::string& what);

/// Bind the flags of each stage to the fields of its options, which hold the defaults.
void add_align_options(CLI::App& command, registration::AlignOptions& options);

/// Adds --calibration and --calibration-samples.
void add_calibration_options(CLI::App& command, registration::CalibrationOptions& options);

/// Angles are degrees on the command line and radians in the options.
struct RefineFlags {
  hybrid::RefineOptions options;
  std::optional<double> sigma_normal_deg;

  hybrid::RefineOptions resolved() const;
};
void add_refine_options(CLI::App& command, RefineFlags& flags);

struct MergeFlags {
  reconstruction::ModelOptions options;
  bool no_polish = false;
  std::optional<double> polish_sigma_normal_deg;

  reconstruction::ModelOptions resolved() const;
};
void add_merge_options(CLI::App& command, MergeFlags& flags);

}  // namespace relief
