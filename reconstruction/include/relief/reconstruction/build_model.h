#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "relief/fusion/decimate_mesh.h"
#include "relief/fusion/merge_views.h"
#include "relief/hybrid/polish_mesh.h"
#include "relief/scan/context.h"
#include "relief/scan/mesh_check.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::reconstruction {

enum class Stage { kAlign, kCalibrate, kCompare, kRefine, kAlignAgain, kMerge, kPolish };
inline constexpr int kStages = 7;

/// `align`, `calibrate`, `compare`, `refine`, `align again`, `merge` or `polish`.
std::string_view to_string(Stage stage);

/// Told how far a stage is: `fraction` in [0, 1] of its step named `step`. Returning false asks to
/// stop: the computation then returns ErrorKind::kInterrupted. Called from the thread that started
/// the computation only.
using StageProgress = std::function<bool(Stage stage, double fraction, std::string_view step)>;

struct ModelOptions {
  fusion::MergeOptions merge;
  /// Nothing: the mesh stays as merged.
  std::optional<hybrid::PolishOptions> polish = hybrid::PolishOptions{};
  fusion::DecimationOptions decimation;  ///< Asks for nothing by default.
};

struct Model {
  TriangleMesh mesh;  ///< See fusion::MergeResult::mesh for its attributes.
  MeshCheck check;    ///< Of `mesh`.
  fusion::MergeSummary merged;
  std::optional<hybrid::PolishSummary> polished;  ///< Nothing: not asked for, or not kept.
  /// Before decimation; nothing: not asked for.
  std::optional<std::size_t> faces_before_decimation;
};

/// Merges views at their `world_from_view`, refines the mesh with the normals of the views, and
/// decimates it as far as the options ask. A mesh that merging closed stays closed and manifold:
/// where polishing would leave no closed manifold, the mesh stays as merged, and `merged.notes`
/// says so. The merged and the polished mesh are units of work. `progress` is told of each stage,
/// the progress of the context of all stages together. Errors: those of fusion::merge_views,
/// hybrid::polish_mesh and fusion::decimate_mesh.
Result<Model> build_model(const std::vector<RangeView>& views, const ModelOptions& options = {},
                          const Context& context = {}, const StageProgress& progress = {});

/// The views that polishing looks at, all at once. Asked for after merging; its errors end the
/// computation.
using LoadAllViews =
    std::function<Result<const std::vector<RangeView>*>(const fusion::MergeResult& merged)>;

/// The same from views that merging reads one at a time. The pointer that `all` gives must stay
/// valid until the function returns.
Result<Model> build_model_from_source(const fusion::ViewSource& views, const LoadAllViews& all,
                                      const ModelOptions& options = {}, const Context& context = {},
                                      const StageProgress& progress = {});

}  // namespace relief::reconstruction
