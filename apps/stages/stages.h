#pragma once

#include <optional>

#include "apps/commands/command.h"
#include "apps/reports/report.h"
#include "relief/fusion/decimate_mesh.h"
#include "relief/fusion/merge_views.h"
#include "relief/hybrid/polish_mesh.h"
#include "relief/hybrid/refine_view.h"
#include "relief/registration/align_views.h"

namespace relief {

/// Each stage with its progress, its log lines and its section of the report.

/// Sets the poses of `project`. `complete` is false when a view could not be aligned or the poses
/// could not be refined to the end.
struct AlignStage {
  bool complete = true;
  Json report;
};
Result<AlignStage> align_stage(ScanProject& project, const registration::AlignOptions& options);

/// Warns of the views that the section of the report says are not aligned.
void warn_of_unaligned(const Json& align_report);

/// Replaces the views of `project` by the refined ones. `complete` is false when a solve failed.
/// `memory` [bytes] is that of refine_views.
struct RefineStage {
  bool complete = true;
  bool any_refined = false;
  Json report;
};
Result<RefineStage> refine_stage(ScanProject& project, const hybrid::RefineOptions& options,
                                 std::size_t memory);

/// Merges the views and polishes the mesh with their normals.
struct MergeStageOptions {
  fusion::MergeOptions merge;
  std::optional<hybrid::PolishOptions> polish =
      hybrid::PolishOptions{};           ///< Nothing: the mesh stays as merged.
  fusion::DecimationOptions decimation;  ///< Asks for nothing unless told otherwise.
  int threads = 0;                       ///< 0: one per core; takes the place of those above.
};
struct MergeStage {
  TriangleMesh mesh;
  Json report;
};
Result<MergeStage> merge_stage(const ScanProject& project, const MergeStageOptions& options);
/// The same model within `options.merge.memory`: the views are read one at a time. kUnsolvable when
/// polishing, which holds all views and the mesh in memory, would exceed it.
Result<MergeStage> merge_stage_within_limit(const ProjectInput& input,
                                            const MergeStageOptions& options);

}  // namespace relief
