#pragma once

#include <optional>
#include <string_view>

#include "reconstruction/cache/stage_units.h"
#include "relief/reconstruction/build_model.h"
#include "relief/reconstruction/reconstruct_part.h"
#include "relief/scan/context.h"

namespace relief::reconstruction {

/// The context of a reconstruction, or of a part of one, for one stage at a time.
struct StageContext {
  const Context& context;
  const StageProgress& progress;
  ReconstructionPart part = {};

  /// Whose progress tells the stage as well. The object must outlive it.
  Context of(Stage stage) const {
    return context.with_progress([this, stage](double fraction, std::string_view step) {
      if (!report_progress(context.progress, overall(stage, fraction), step)) return false;
      return !progress || progress(stage, fraction, step);
    });
  }

  /// What the stage ends with instead of computing a unit that is not in the store.
  MissingUnitError missing_unit_error(Stage stage) const {
    const bool only_find = stage < part.last ? part.find_former : part.find_last;
    if (!only_find) return std::nullopt;
    return Error{ErrorKind::kBadInput,
                 "step " + step_name(stage) +
                     " comes first: nothing is kept of it for these inputs and options, and this "
                     "build of the program"};
  }

 private:
  // Stages count alike: how long each takes depends on the data.
  static double overall(Stage stage, double fraction) {
    return (static_cast<double>(stage) + fraction) / kStages;
  }
};

/// build_model(), within a reconstruction.
Result<Model> build_model_in(const StageContext& stages, const std::vector<RangeView>& views,
                             const ModelOptions& options);

}  // namespace relief::reconstruction
