#include "apps/commands/plan/step_states.h"

#include <memory>

#include "reconstruction/cache/folder_lock.h"
#include "relief/reconstruction/unit_folder.h"

namespace relief {

namespace {

using reconstruction::ReconstructionCallbacks;
using reconstruction::ReconstructionPart;
using reconstruction::Stage;

// How far a reconstruction came that only finds. Stages that are left out tell nothing: what is
// told of a later one stands for them.
struct Reached {
  std::optional<Stage> last;

  ReconstructionCallbacks callbacks() {
    ReconstructionCallbacks callbacks;
    callbacks.aligned = [this](const auto&) { return reach(Stage::kAlign); };
    callbacks.calibrated = [this](const auto&, const auto&) { return reach(Stage::kCalibrate); };
    callbacks.compared = [this](const auto&, const auto&) { return reach(Stage::kCompare); };
    callbacks.refined = [this](const auto&, const auto&) { return reach(Stage::kRefine); };
    callbacks.views_finished = [this](const auto&) { return reach(Stage::kAlignAgain); };
    return callbacks;
  }
  Result<void> reach(Stage stage) {
    last = stage;
    return {};
  }
};

// The stage after `reached` that a run with these options has.
Stage next_stage(std::optional<Stage> reached,
                 const reconstruction::ReconstructionOptions& options) {
  if (!reached) return Stage::kAlign;
  auto next = *reached;
  do {
    next = static_cast<Stage>(static_cast<int>(next) + 1);
  } while (!reconstruction::has_stage(next, options));
  return next;
}

}  // namespace

Result<StepStates> find_steps(const std::vector<RangeView>& views,
                              const std::vector<ReconstructionPart>& parts,
                              const reconstruction::ReconstructionOptions& options,
                              const std::filesystem::path& output, Context context) {
  const auto cache = reconstruction::private_folder(output) / "cache";
  std::error_code ignored;
  if (!std::filesystem::is_directory(cache, ignored)) return StepStates();
  const auto units = reconstruction::UnitFolder::open(cache);
  if (!units) return StepStates();
  context.store = units->get();

  const auto find = [&](ReconstructionPart part, const ReconstructionCallbacks& callbacks) {
    part.find_former = part.find_last = true;
    return reconstruction::reconstruct_part(views, part, options, context, callbacks);
  };
  Reached reached;
  const auto all = find({}, reached.callbacks());
  StepStates states;
  states.first_missing = std::nullopt;
  if (all) return states;
  if (all.error().kind != ErrorKind::kBadInput) return all.error();
  states.first_missing = next_stage(reached.last, options);
  if (states.first_missing == Stage::kMerge && (*units)->counts()["merge"].found > 0)
    states.first_missing = Stage::kPolish;
  const bool none_refined =
      states.first_missing == Stage::kRefine && (*units)->counts()["refine"].found == 0;
  for (const ReconstructionPart& part : parts)
    if (part.last == states.first_missing)
      states.parts_done.push_back(!none_refined && find(part, {}).ok());
  return states;
}

}  // namespace relief
