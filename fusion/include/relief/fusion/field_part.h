#pragma once

#include <cstddef>
#include <vector>

#include "relief/fusion/merge_views.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::fusion {

/// A part of the closed field (docs/fusion.md) that may be computed ahead of merge_views(), by a
/// process of its own.
struct FieldPart {
  std::size_t brick = 0;  ///< Of the finest level, in [0, bricks).
  /// In so many bricks, runs of blocks in their order, the finest level is cut. 0: the part is all
  /// coarser levels.
  std::size_t bricks = 0;
};

/// Computes a part of the field and keeps it in the store of the context, where merge_views() with
/// the same views and options finds it. The coarser levels come first: a brick finds them in the
/// store, else it computes them. What views say of a node of the finest level depends on nothing
/// else. So bricks may be computed in any order, by several processes that share one store, and the
/// merged surface is the same to the byte.
///
/// Returns the number of results of the brick; 0 for the coarser levels, and for bricks of a field
/// that has fewer. Errors: those of merge_views(), and kBadInput where there is no such brick, or
/// no store.
Result<std::size_t> compute_field_part(const std::vector<RangeView>& views,
                                       const MergeOptions& options, const FieldPart& part,
                                       const Context& context);

}  // namespace relief::fusion
