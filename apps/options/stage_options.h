#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "relief/hybrid/refine_view.h"
#include "relief/reconstruction/build_model.h"
#include "relief/registration/align_views.h"
#include "relief/registration/calibrate_views.h"

namespace relief {

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
