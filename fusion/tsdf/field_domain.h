#pragma once

#include <cmath>
#include <vector>

#include "fusion/tsdf/lattice.h"
#include "fusion/tsdf/sparse_field.h"
#include "fusion/views/view_sampler.h"
#include "scan/base/memory/memory_limit.h"

namespace relief::fusion {

/// Free cells of the coarsest lattice on each side of the object. Fewer press what closes an open
/// side against the border; twice as many make 1.7 times the nodes (60^3 / 50^3).
inline constexpr int kPaddingCells = 5;

/// Where a closed field is computed: lattices from the finest, level 0, to the coarsest, each with
/// twice the spacing of the one before and the same origin.
struct FieldDomain {
  Lattice finest;
  int levels = 1;
  Node coarse_cells = Node::Zero();  ///< Of the coarsest lattice, which is dense.

  Lattice lattice(int level) const { return {finest.origin, std::ldexp(finest.spacing, level)}; }
  /// Whether all nodes have keys.
  bool has_keys() const {
    return (coarse_cells.cast<double>() * std::ldexp(1.0, levels)).maxCoeff() < kKeyOffset;
  }
};

/// The domain round the samples of the views. `coarse_cells`: of the coarsest lattice along the
/// longest side. `memory` may be null, here and below.
FieldDomain domain_of(const std::vector<ViewSampler>& views, double voxel_size, double truncation,
                      int coarse_cells, MemoryLimit* memory);

/// The blocks within `reach` [unit] of the views' samples. Sets of blocks are sorted.
std::vector<NodeKey> blocks_near(const std::vector<ViewSampler>& views, const Lattice& lattice,
                                 double reach, MemoryLimit* memory);

/// The blocks of the next coarser lattice that cover `blocks`.
std::vector<NodeKey> parents_of(const std::vector<NodeKey>& blocks);

/// All blocks of a dense lattice.
std::vector<NodeKey> all_blocks(const Node& cells);

/// The blocks of the next finer lattice that cover the cells round the zero set of `field`.
std::vector<NodeKey> finer_blocks_near_zero(const SparseField& field, MemoryLimit* memory);

}  // namespace relief::fusion
