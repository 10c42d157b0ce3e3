#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "hybrid/edge_stencil.h"

namespace relief {

inline constexpr std::uint32_t kNoAggregate = std::numeric_limits<std::uint32_t>::max();

/// Nodes of a coarse level: groups of nodes of the level below that lie in one block of 3 x 3
/// places and hang together. A group moves as a rigid piece: with slopes b_u and b_v, the
/// displacement of a member at (u, v) is x + (u - u_node) metric_u b_u + (v - v_node) metric_v b_v.
struct Aggregates {
  struct Node {
    float u = 0.0f, v = 0.0f;                ///< Centre [pixels].
    float metric_u = 0.0f, metric_v = 0.0f;  ///< Displacement per pixel and slope.
    std::int32_t column = 0, row = 0;        ///< Of the block.
  };
  /// A bond between two nodes; strength as of the conductance of a constraint.
  struct Bond {
    std::uint32_t a = 0, b = 0;
    float strength = 0.0f;
  };

  std::vector<std::uint32_t> label;  ///< Per node below its group; kNoAggregate: none.
  std::vector<Node> nodes;           ///< Ordered by row, then column.
  std::vector<std::uint32_t> rows;   ///< Nodes of block row k are [rows[k], rows[k + 1]).
  std::vector<Bond> bonds;           ///< Between the nodes, a < b, ordered.
};

/// Groups of pixels; labels are by padded index.
Aggregates aggregate_pixels(const EdgeStencil& stencil, int threads);

/// Groups of nodes. Nodes without bonds join none: relaxation solves them alone.
Aggregates aggregate_nodes(const Aggregates& below);

}  // namespace relief
