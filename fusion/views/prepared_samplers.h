#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fusion/views/view_sampler.h"
#include "relief/fusion/merge_views.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"

namespace relief::fusion {

/// The views that take part in merging, prepared for queries.
struct PreparedSamplers {
  std::vector<ViewSampler> samplers;
  std::vector<std::uint16_t> indices;  ///< Of the samplers' views among those given.
  std::vector<std::string> notes;      ///< On views that are left out.
};

/// Prepares all views that have a pose and connected samples. Raw views much finer than
/// `voxel_size` get larger pixels (bin_view); 0: it is not chosen yet, and all stay as they are.
/// kUnsolvable when there are none;
/// kInterrupted; otherwise errors of reading views, or of memory.
Result<PreparedSamplers> prepare_samplers(const ViewSource& views, double voxel_size,
                                          const PagedSurfaceOptions& options,
                                          const Progress& progress);

/// Prepares the views that others contradict anew, without the samples that speak of what these
/// measured, and those without any others no more. `options` and `voxel_size` as before; `result`
/// gets their names and a note. Errors: those of reading views, or of memory.
Result<void> prepare_contradicted(const ViewSource& views, double voxel_size,
                                  const PagedSurfaceOptions& options, const RangeErrors& errors,
                                  PreparedSamplers& prepared, MergeSummary& result);

}  // namespace relief::fusion
