#include "fusion/obstacle_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "scan/parallel.h"

namespace relief {

namespace {

constexpr std::size_t kBlocksAtOnce = 16;

// Relaxes the free nodes of one colour (parity of x + y + z) in a block; the largest change.
// Neighbours of one colour have the other, so blocks can be relaxed in any order.
float relax_block(SparseField& field, std::span<const NodeConstraint> constraints, std::size_t b,
                  int colour, float relaxation) {
  float* values = field.values(b);
  const NodeConstraint* constraint = constraints.data() + b * kBlockNodes;
  const auto beside = [&](int dx, int dy, int dz) {
    return field.values(static_cast<std::size_t>(field.neighbour(b, dx, dy, dz)));
  };
  const std::array<const float*, 6> sides{beside(-1, 0, 0), beside(1, 0, 0),  beside(0, -1, 0),
                                          beside(0, 1, 0),  beside(0, 0, -1), beside(0, 0, 1)};
  float largest = 0.0f;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      for (int x = (y + z + colour) & 1; x < 8; x += 2) {
        const int i = x | y << 3 | z << 6;
        if (constraint[i].fixed()) continue;
        const float sum = (x > 0 ? values[i - 1] : sides[0][i + 7]) +
                          (x < 7 ? values[i + 1] : sides[1][i - 7]) +
                          (y > 0 ? values[i - 8] : sides[2][i + 56]) +
                          (y < 7 ? values[i + 8] : sides[3][i - 56]) +
                          (z > 0 ? values[i - 64] : sides[4][i + 448]) +
                          (z < 7 ? values[i + 64] : sides[5][i - 448]);
        const float relaxed = values[i] + relaxation * (sum / 6.0f - values[i]);
        const float bounded = std::max(relaxed, constraint[i].floor);
        largest = std::max(largest, std::abs(bounded - values[i]));
        values[i] = bounded;
      }
    }
  }
  return largest;
}

std::vector<std::size_t> blocks_with_free_nodes(const SparseField& field,
                                                std::span<const NodeConstraint> constraints,
                                                MemoryLimit* memory) {
  std::vector<std::size_t> blocks;
  for (std::size_t b = 0; b < field.block_count(); ++b) {
    if (b % kBlocksAtOnce == 0) relieve(memory);
    const auto of_block = constraints.subspan(b * kBlockNodes, kBlockNodes);
    if (field.active(b) && std::any_of(of_block.begin(), of_block.end(),
                                       [](const NodeConstraint& c) { return !c.fixed(); }))
      blocks.push_back(b);
  }
  return blocks;
}

}  // namespace

int solve_obstacle_problem(SparseField& field, std::span<const NodeConstraint> constraints,
                           const ObstacleSolverOptions& options) {
  const std::vector<std::size_t> blocks =
      blocks_with_free_nodes(field, constraints, options.memory);
  const auto tolerance = static_cast<float>(options.tolerance * field.lattice().spacing);
  std::vector<float> change(blocks.size());
  for (int sweep = 0; sweep < options.max_sweeps; ++sweep) {
    std::fill(change.begin(), change.end(), 0.0f);
    for (const int colour : {0, 1}) {
      parallel_for(blocks.size(), kBlocksAtOnce, options.threads, [&](auto begin, auto end) {
        relieve(options.memory);
        for (std::size_t k = begin; k < end; ++k)
          change[k] = std::max(change[k], relax_block(field, constraints, blocks[k], colour,
                                                      static_cast<float>(options.relaxation)));
      });
    }
    if (change.empty() || *std::max_element(change.begin(), change.end()) <= tolerance)
      return sweep + 1;
  }
  return options.max_sweeps;
}

}  // namespace relief
