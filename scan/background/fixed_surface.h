#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "scan/background/depth_stack.h"

namespace relief {

/// The surface that stands still in the camera's frame: at each pixel the farthest depth that
/// several views measured alike. No view sees through what stands still, so nothing is behind it.
struct FixedSurface {
  Grid<float> depth;  ///< [unit]; NaN where no depth recurs.
  /// Pixels that hang together share a number from 0 on; -1: none, or too few.
  Grid<std::int32_t> piece;
  std::size_t pieces = 0;
  /// The second farthest depth, which two views or more reach, or that of the only one [unit]; NaN
  /// without any.
  Grid<float> behind;
};

FixedSurface find_fixed_surface(const DepthStack& stack);

/// What the depth of a sample says of it.
enum class SampleKind : std::uint8_t {
  kNone,      ///< No sample.
  kStanding,  ///< On a piece of the standing surface.
  kMoving,    ///< Other views see what is behind it.
  kUnknown,   ///< No other view sees farther here, or only one.
};

/// The kinds of the samples of a view. `depths`: along the rays of the stack, `tolerance`: as in
/// DepthStack.
Grid<SampleKind> classify_samples(const FixedSurface& surface, const Grid<float>& tolerance,
                                  const Grid<float>& depths);

}  // namespace relief
