#include "fusion/tsdf/obstacle_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

constexpr std::size_t kBlocksAtOnce = 16;  // Of one piece of work; changes no result.
constexpr std::array<std::array<int, 3>, 6> kSides{
    {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

// Nodes with values beyond this are not beside the zero set [spacings]: a cell's diagonal is
// sqrt(3). What they change by counts for so much less, so they rest at 0.03 spacings, not 0.001.
constexpr float kBeside = 2.0f, kFarShare = 1.0f / 30.0f;

// Relaxes the free nodes of one colour (parity of x + y + z) in a block; the largest change, of
// values far from zero by their share.
// Neighbours of one colour have the other, so blocks can be relaxed in any order.
float relax_block(SparseField& field, std::span<const NodeConstraint> constraints, std::size_t b,
                  int colour, float relaxation) {
  const float beside = kBeside * static_cast<float>(field.lattice().spacing);
  float* values = field.values(b);
  const NodeConstraint* constraint = constraints.data() + b * kBlockNodes;
  std::array<const float*, 6> sides;
  for (std::size_t k = 0; k < 6; ++k)
    sides[k] = field.values(
        static_cast<std::size_t>(field.neighbour(b, kSides[k][0], kSides[k][1], kSides[k][2])));
  float largest = 0.0f;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      const int row = y << 3 | z << 6;
      const float* const above = y > 0 ? values + row - 8 : sides[2] + row + 56;
      const float* const below = y < 7 ? values + row + 8 : sides[3] + row - 56;
      const float* const before = z > 0 ? values + row - 64 : sides[4] + row + 448;
      const float* const behind = z < 7 ? values + row + 64 : sides[5] + row - 448;
      for (int x = (y + z + colour) & 1; x < 8; x += 2) {
        const int i = row | x;
        if (constraint[i].fixed()) continue;
        const float sum = (x > 0 ? values[i - 1] : sides[0][i + 7]) +
                          (x < 7 ? values[i + 1] : sides[1][i - 7]) + above[x] + below[x] +
                          before[x] + behind[x];
        const float relaxed = values[i] + relaxation * (sum / 6.0f - values[i]);
        const float bounded = std::max(relaxed, constraint[i].floor);
        const float share = std::abs(bounded) < beside ? 1.0f : kFarShare;
        largest = std::max(largest, share * std::abs(bounded - values[i]));
        values[i] = bounded;
      }
    }
  }
  return largest;
}

// The blocks that have free nodes to relax, and which of them still change.
class MovingBlocks {
 public:
  MovingBlocks(const SparseField& field, std::span<const NodeConstraint> constraints,
               const ObstacleSolverOptions& options)
      : field_(field),
        tolerance_(static_cast<float>(options.tolerance * field.lattice().spacing)),
        change_(field.block_count(), 0.0f) {
    for (std::size_t b = 0; b < field.block_count(); ++b) {
      if (b % kBlocksAtOnce == 0) evict_pages(options.memory);
      const auto of_block = constraints.subspan(b * kBlockNodes, kBlockNodes);
      if (field.active(b) && std::any_of(of_block.begin(), of_block.end(),
                                         [](const NodeConstraint& c) { return !c.fixed(); })) {
        solved_.push_back(b);
        change_[b] = std::numeric_limits<float>::infinity();
      }
    }
  }

  /// Those where a value, or one of a block beside, changed by more than the tolerance when last
  /// relaxed.
  std::vector<std::size_t> find() const {
    std::vector<std::size_t> moving;
    for (const std::size_t b : solved_) {
      float change = change_[b];
      for (const auto& [dx, dy, dz] : kSides) {
        const std::int32_t beside = field_.neighbour(b, dx, dy, dz);
        if (beside >= 0) change = std::max(change, change_[static_cast<std::size_t>(beside)]);
      }
      if (change > tolerance_) moving.push_back(b);
    }
    return moving;
  }

  void relaxed(std::size_t b, float change) { change_[b] = change; }

 private:
  const SparseField& field_;
  float tolerance_;
  std::vector<std::size_t> solved_;
  std::vector<float> change_;  // Of each block when it was last relaxed.
};

}  // namespace

ObstacleSolution solve_obstacle_problem(SparseField& field,
                                        std::span<const NodeConstraint> constraints,
                                        const ObstacleSolverOptions& options) {
  MovingBlocks moving(field, constraints, options);
  const auto relaxation = static_cast<float>(options.relaxation);
  for (int sweep = 0; sweep < options.max_sweeps; ++sweep) {
    const std::vector<std::size_t> blocks = moving.find();
    if (blocks.empty()) return {sweep, 0};
    if (options.go_on && !options.go_on()) return {sweep, blocks.size()};
    std::vector<float> change(blocks.size(), 0.0f);
    for (const int colour : {0, 1}) {
      parallel_for(blocks.size(), kBlocksAtOnce, [&](auto begin, auto end) {
        evict_pages(options.memory);
        for (std::size_t k = begin; k < end; ++k)
          change[k] =
              std::max(change[k], relax_block(field, constraints, blocks[k], colour, relaxation));
      });
    }
    for (std::size_t k = 0; k < blocks.size(); ++k) moving.relaxed(blocks[k], change[k]);
  }
  return {options.max_sweeps, moving.find().size()};
}

}  // namespace relief::fusion
