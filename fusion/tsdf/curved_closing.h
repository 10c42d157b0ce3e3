#pragma once

#include <functional>
#include <span>
#include <vector>

#include "fusion/tsdf/obstacle_solver.h"
#include "fusion/tsdf/sparse_field.h"
#include "fusion/views/view_sampler.h"

namespace relief::fusion {

struct CurvedClosingOptions {
  double truncation = 0.0;  ///< As used for the field [unit].
  /// Regions of more vertices stay as they are: a coarser level had them.
  std::size_t most_vertices = 25000;
  /// How often the surface is bent and the field solved anew, at most.
  int rounds = 1;
  MemoryLimit* memory = nullptr;  ///< May be null.
};

/// Makes the zero set of a solved field go on with the slope and curvature it arrives with where
/// views measured nothing. The membrane that the field has there is bent as a surface
/// (bend_filled_regions()). Nodes beside it that nobody measured are held at their distance from
/// it, or at their floors, and `solve` is called, which is to solve the field again.
/// `constraints` has an entry per node, in the order of the field's blocks.
/// Returns whether anything was bent: nothing is unless the views saw the object from one side.
bool close_curved(SparseField& field, const std::vector<ViewSampler>& views,
                  std::span<NodeConstraint> constraints, const CurvedClosingOptions& options,
                  const std::function<void()>& solve);

}  // namespace relief::fusion
