#pragma once

#include <cstddef>
#include <vector>

#include "relief/registration/align_options.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::registration {

/// Pairs of views that are searched first, for each view.
inline constexpr std::size_t kFirstPairsPerView = 2;

/// One of `count` blocks of a list: every `count`th element, beginning with that of `index`.
struct PairBlock {
  std::size_t index = 0;  ///< In [0, count).
  std::size_t count = 1;
};

/// Searches for the relative poses of a block of pairs of views, by their shape: of those pairs
/// that align_views() searches first, which are the most similar ones, two for each view. Which
/// pairs it searches after them depends on what it finds. Each pair is a unit of work in the store
/// of the context, and so is whether a view of the block fits itself. So several processes may
/// search, each a block, before align_views() with the same views and options finds the units.
///
/// Returns the number of pairs in the block. It is 0 where align_views() needs no search, as when
/// the given poses hold. Errors: those of align_views(), and kBadInput where there is no such
/// block.
Result<std::size_t> search_pairs(const std::vector<RangeView>& views, const AlignOptions& options,
                                 const PairBlock& block, const Context& context);

}  // namespace relief::registration
