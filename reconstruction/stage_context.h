#pragma once

#include <string_view>

#include "relief/reconstruction/build_model.h"
#include "relief/scan/context.h"

namespace relief::reconstruction {

/// The context of a reconstruction, for one stage at a time.
struct StageContext {
  const Context& context;
  const StageProgress& progress;

  /// Whose progress tells the stage as well. The object must outlive it.
  Context of(Stage stage) const {
    return context.with_progress([this, stage](double fraction, std::string_view step) {
      if (!report_progress(context.progress, overall(stage, fraction), step)) return false;
      return !progress || progress(stage, fraction, step);
    });
  }

 private:
  // Stages count alike: how long each takes depends on the data.
  static double overall(Stage stage, double fraction) {
    return (static_cast<double>(stage) + fraction) / kStages;
  }
};

}  // namespace relief::reconstruction
