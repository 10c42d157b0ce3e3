#pragma once

#include <string>
#include <vector>

#include "apps/console/progress_format.h"
#include "apps/console/progress_plan.h"
#include "relief/reconstruction/build_model.h"
#include "relief/scan/context.h"

namespace relief {

void set_progress_format(ProgressFormat format);

/// From now on progress is that of a whole command of these stages.
void plan_progress(std::vector<PlannedStage> stages);

/// A progress callback for one stage. It asks the computation to stop after Ctrl-C or a termination
/// signal.
Progress console_progress(const std::string& stage);

/// The same for a computation of several stages.
reconstruction::StageProgress console_stage_progress();

}  // namespace relief
