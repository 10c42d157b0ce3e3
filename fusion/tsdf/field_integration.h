#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "fusion/tsdf/obstacle_solver.h"
#include "fusion/tsdf/sparse_field.h"
#include "fusion/units/merge_units.h"
#include "fusion/views/view_sampler.h"

namespace relief::fusion {

struct FieldIntegrationOptions {
  double truncation = 0.0;  ///< Views measure up to this distance from their surface [unit], > 0.
  float limit = 0.0f;       ///< Values beyond are cut to it [unit], > 0.
  MemoryLimit* memory = nullptr;  ///< Of the field; may be null.
  /// Asked before each group, with the number of it; false ends the integration. May be empty.
  std::function<bool(std::size_t group)> go_on;
};

/// Of the blocks of a field in their order, so many at a time are integrated, and kept: about a
/// second of work, and 16 MB.
inline constexpr std::size_t kBlocksOfGroup = 4096;

std::size_t group_count(const SparseField& field);

/// Integrates the views (docs/fusion.md, F1 to F4) into the active blocks of the groups from
/// `begin` to `end`. Nodes that views measured get their signed distance, and are fixed. The floor
/// of the others is the clearance that views saw, and their value is not below it. `constraints`
/// has one entry per node of the field. Of a node depends only what
/// the field had there before and what views say of it. So groups may be integrated in any order,
/// and by several processes. Groups that `units` has are not computed, and with `keep` it gets all
/// others; under a limit of memory where there is room. False when `go_on` asked to stop.
bool integrate_views(const std::vector<ViewSampler>& views, std::size_t begin, std::size_t end,
                     const FieldIntegrationOptions& options, const FieldUnits& units, bool keep,
                     SparseField& field, PagedArray<NodeConstraint>& constraints);

}  // namespace relief::fusion
