#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "apps/commands/command.h"
#include "apps/commands/outputs.h"
#include "apps/commands/run/run_cache.h"
#include "apps/options/memory_option.h"
#include "apps/options/stage_options.h"
#include "apps/reports/html/html_report.h"
#include "apps/reports/report.h"
#include "relief/reconstruction/reconstruct_part.h"

namespace relief {

/// All that `run`, its steps and its plan are told. The keys of units depend on it.
struct RunOptions {
  CommonOptions common;
  ProjectInput input;
  registration::AlignOptions align;
  registration::CalibrationOptions calibration;
  reconstruction::ContradictedRanges contradicted = reconstruction::ContradictedRanges::kCorrect;
  RefineFlags refine;
  MemoryFlag memory;
  MergeFlags merge;
  std::filesystem::path output;
  std::vector<std::filesystem::path> exports;
  double time_limit = 0.0;  // [s]; 0: none.
  bool no_html_report = false;
  HtmlReportOptions html;
  CacheFlags cache;
  Json record;  // Of the section `run` of the report: what is known before the views are read.

  /// What the library is told.
  reconstruction::ReconstructionOptions reconstruction() const;
  /// All that `run` writes outside of DIR/.relief.
  Outputs outputs() const;
  /// The context of a reconstruction. Its stages are told apart by the callbacks.
  Context context(UnitStore* store) const;
};

/// Adds the positional PROJECT and all options of `run`. `options` must outlive `command`.
void add_run_options(CLI::App& command, RunOptions& options);

/// The command `run`: the whole way, all of it or only as far as `part` lets units be computed.
/// Returns the exit status.
int run(const RunOptions& options, const reconstruction::ReconstructionPart& part = {});

}  // namespace relief
