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
  std::vector<bool> searched;  ///< Where kAlign is the first: by block of pairs.
  std::vector<bool> refined;  ///< Where kRefine is the first: by block, whether all of it is there.
};

/// Looks for the units of `views` in the folder `output`, which may be missing. Computes nothing.
/// `blocks`: the views that are refined together, by their indices; `pair_blocks`: how many blocks
/// of pairs are searched. Errors: kInterrupted, and those of results that do not allow a model.
Result<StepStates> find_steps(const std::vector<RangeView>& views,
                              const std::vector<std::vector<std::size_t>>& blocks,
                              std::size_t pair_blocks,
                              const reconstruction::ReconstructionOptions& options,
                              const std::filesystem::path& output, Context context);

}  // namespace relief
