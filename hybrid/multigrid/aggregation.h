#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "hybrid/multigrid/edge_stencil.h"

namespace relief::hybrid {

inline constexpr std::uint32_t kNoAggregate = std::numeric_limits<std::uint32_t>::max();

/// How a displacement is carried from one place of a surface to another by the constraints between
/// them when the slopes are the same at both: x_to = scale x_from + along_u b_u + along_v b_v.
struct Transport {
  float scale = 1.0f, along_u = 0.0f, along_v = 0.0f;

  Transport then(const Transport& next) const {
    return {next.scale * scale, next.scale * along_u + next.along_u,
            next.scale * along_v + next.along_v};
  }
  Transport inverse() const { return {1.0f / scale, -along_u / scale, -along_v / scale}; }
};

/// The nodes of a coarse level: groups of nodes of the level below that lie in one block of 3 x 3
/// places and hang together. A group moves as a rigid piece.
struct Aggregates {
  struct Node {
    std::int32_t column = 0, row = 0;  ///< Of the block.
  };
  struct Bond {
    std::uint32_t a = 0, b = 0;
    float strength = 0.0f;  ///< Weight of the constraints between the two.
    Transport b_from_a;
  };

  std::vector<std::uint32_t> label;  ///< Per node below its group; kNoAggregate: none.
  std::vector<Transport> from_root;  ///< Per node below, from its group's displacement to its own.
  std::vector<Node> nodes;           ///< Ordered by row, then column.
  std::vector<std::uint32_t> rows;   ///< Nodes of block row k are [rows[k], rows[k + 1]).
  std::vector<Bond> bonds;           ///< Between the nodes, a < b, ordered, each pair once.
};

/// Groups of pixels; labels and transports are by padded index.
Aggregates aggregate_pixels(const EdgeStencil& stencil);

/// Groups of nodes. Nodes without bonds join none: relaxation solves them alone.
Aggregates aggregate_nodes(const Aggregates& below);

}  // namespace relief::hybrid
