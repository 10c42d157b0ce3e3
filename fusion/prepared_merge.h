#pragma once

#include "fusion/tsdf/closed_field.h"
#include "fusion/units/merge_units.h"
#include "fusion/views/prepared_samplers.h"
#include "relief/fusion/merge_views.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"

namespace relief::fusion {

/// All that merging needs before its field.
struct PreparedMerge : PreparedSamplers {
  double nominal_deviation = 0.0;  ///< Median of the views' median deviations [unit]; 0: none.
  double sample_spacing = 0.0;  ///< Of the typical view as given [unit]; 0: voxels go by samples.
  FieldUnits units;
};

/// Prepares the views and chooses voxel size and truncation. What was chosen, and counts and notes
/// on samples and views, go to `result`. `store` and `memory` may be null. Errors: those of
/// merge_from_source().
Result<PreparedMerge> prepare_merge(const ViewSource& views, const MergeOptions& options,
                                    UnitStore* store, MemoryLimit* memory, const Progress& progress,
                                    MergeSummary& result);

/// By what was chosen.
ClosedFieldOptions field_options(const MergeSummary& chosen, const FieldUnits& units,
                                 MemoryLimit* memory);

/// What single views err by [unit]: the noise they show, or what they are apart by.
double view_stddev(const MergeSummary& chosen);

/// Progress of a part of merging, which is from `begin` to `end` of `whole`, which outlives it.
Progress part_of(const Progress& whole, double begin, double end);

/// Views that are all in memory already, and outlive the source.
ViewSource source_of(const std::vector<RangeView>& views);

}  // namespace relief::fusion
