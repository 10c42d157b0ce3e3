#pragma once

#include <cstddef>
#include <optional>

#include <CLI/CLI.hpp>

#include "relief/hybrid/refine_view.h"
#include "relief/reconstruction/build_model.h"
#include "relief/registration/align_views.h"

namespace relief {

/// Bind the flags of each stage to the fields of its options, which hold the defaults.
void add_align_options(CLI::App& command, registration::AlignOptions& options);

/// Angles are degrees on the command line and radians in the options.
struct RefineFlags {
  hybrid::RefineOptions options;
  std::optional<double> sigma_normal_deg;
  std::size_t memory_mb = 0;

  hybrid::RefineOptions resolved() const;
  std::size_t memory() const { return memory_mb << 20; }  ///< [bytes]
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
