#pragma once

#include <cstddef>
#include <cstdint>

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "scan/background/depth_stack.h"
#include "scan/background/fixed_surface.h"

namespace relief {

/// 1 for the samples of a view of the stack that belong to the background, whose depths are
/// `background` [unit], NaN where it has none. These are the samples on it, what few views know
/// more of and that is continuous with it or lies on its plane, and specks that noise cut off from
/// it. `view` counts in the stack; `kinds` and `edges` are those of that view.
Grid<std::uint8_t> mark_background(const DepthStack& stack, std::size_t view,
                                   const Grid<SampleKind>& kinds, const Grid<float>& background,
                                   const GridEdges& edges);

}  // namespace relief
