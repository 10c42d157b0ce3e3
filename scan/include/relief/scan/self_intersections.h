#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "relief/scan/triangle_mesh.h"

namespace relief {

struct SelfIntersectionOptions {
  /// The search ends soon after so many pairs are found. >= 1.
  std::size_t limit = 1000000;
};

struct SelfIntersections {
  /// Pairs (f, g) of faces, f < g, in ascending order; at most `limit`.
  std::vector<std::array<std::uint32_t, 2>> pairs;
  bool complete = true;  ///< False: there may be more pairs than those listed.

  /// The faces in any of the pairs, in ascending order.
  std::vector<std::uint32_t> faces() const;
};

/// All pairs of faces with a common point that is not on a corner or an edge of both: faces that
/// cross, touch, or lie over each other. Exact for the given doubles (see triangle_overlap.h).
/// Vertices at exactly one place count as one, so that it does not matter whether a mesh is welded.
/// Faces with exactly collinear corners, a vertex that is not finite, or an index out of range have
/// no part in it. Takes about two seconds of one core per million faces.
SelfIntersections find_self_intersections(const TriangleMesh& mesh,
                                          const SelfIntersectionOptions& options = {});

}  // namespace relief
