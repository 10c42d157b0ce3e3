#pragma once

#include "apps/command.h"
#include "apps/report.h"
#include "fusion/merge_views.h"
#include "hybrid/refine_view.h"
#include "registration/align_views.h"

namespace relief {

/// Each stage with its progress, its log lines and its section of the report.

/// Sets the poses of `project`. `complete` is false when a view could not be aligned.
struct AlignStage {
  bool complete = true;
  Json report;
};
Result<AlignStage> align_stage(ScanProject& project, const AlignOptions& options);

/// Replaces the views of `project` by the refined ones. `complete` is false when a solve failed.
struct RefineStage {
  bool complete = true;
  bool any_refined = false;
  Json report;
};
Result<RefineStage> refine_stage(ScanProject& project, const RefineOptions& options);

struct MergeStage {
  TriangleMesh mesh;
  Json report;
};
Result<MergeStage> merge_stage(const ScanProject& project, const MergeOptions& options);

}  // namespace relief
