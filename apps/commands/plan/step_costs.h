#pragma once

#include <cstddef>

#include "apps/commands/plan/project_size.h"
#include "relief/reconstruction/build_model.h"

namespace relief {

struct StepCost {
  double cpu_seconds = 0.0;   ///< Of all threads together.
  double memory_bytes = 0.0;  ///< Peak of the process.
  double disk_bytes = 0.0;    ///< Of the results that the step keeps.
};

/// What one step costs, reading the project and the results of the steps before it included.
/// Aligning costs what it does alone, searched pairs included.
/// `share`: of the samples, that the step works on; less than 1 for blocks of refining.
StepCost cost_of(reconstruction::Stage stage, const ProjectSize& size, double share = 1.0);

/// The same of what `run` does after all stages.
StepCost cost_of_finish(const ProjectSize& size);

/// What one of `blocks` blocks of the pairs costs that are searched ahead of the alignment.
StepCost cost_of_search(const ProjectSize& size, std::size_t blocks);

/// What the coarser levels of the field cost ahead of merging, and one of `bricks` bricks of the
/// finest level, and what merging costs after all of them. Every brick reads and prepares all
/// views, which is more than it integrates unless voxels are smaller than the sample spacing.
StepCost cost_of_coarse_field(const ProjectSize& size);
StepCost cost_of_brick(const ProjectSize& size, std::size_t bricks);
StepCost cost_of_merge_after_parts(const ProjectSize& size);

/// In how many blocks the pairs are searched: 0 where none are, or where one process is as fast.
std::size_t blocks_to_search(const ProjectSize& size);

/// In how many blocks the views are refined: as many as there are views, unless blocks would take
/// longer to read the project than to refine.
std::size_t blocks_to_refine(const ProjectSize& size);

}  // namespace relief
