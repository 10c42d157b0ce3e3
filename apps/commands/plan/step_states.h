#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "relief/reconstruction/reconstruct_part.h"

namespace relief {

/// What a folder holds of the steps of a run.
struct StepStates {
  /// The first stage of which a unit is missing; nothing: all are there. Keys of later stages
  /// depend on its result, so nobody can tell what is there of them.
  std::optional<reconstruction::Stage> first_missing = reconstruction::Stage::kAlign;
  /// Of the parts of the first stage, in their order, whether all of each is there.
  std::vector<bool> parts_done;
};

/// Looks for the units of `views` in the folder `output`, which may be missing. Computes nothing.
/// `parts`: what is a step of its own but no whole stage, such as blocks of views to refine.
/// Errors: kInterrupted, and those of results that do not allow a model.
Result<StepStates> find_steps(const std::vector<RangeView>& views,
                              const std::vector<reconstruction::ReconstructionPart>& parts,
                              const reconstruction::ReconstructionOptions& options,
                              const std::filesystem::path& output, Context context);

}  // namespace relief
