#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <span>

#include "fusion/tsdf/sparse_field.h"

namespace relief::fusion {

/// What is known at one node of a field.
struct NodeConstraint {
  float floor = 0.0f;  ///< The value is not below this; NaN: it stays as it is.

  bool fixed() const { return floor != floor; }
};
inline constexpr NodeConstraint kFixedNode{std::numeric_limits<float>::quiet_NaN()};

struct ObstacleSolverOptions {
  /// Over-relaxation factor, 1 to below 2. 1.5 is the optimum, 2 / (1 + sin(pi / n)), for waves of
  /// n = 9 cells. It changes the time and, within the tolerance, no value.
  double relaxation = 1.5;
  int max_sweeps = 1000;  ///< Bounds the time; ObstacleSolution tells what still moves.
  /// A block rests while no value in it and beside it changes by more than this times the spacing;
  /// by thirty times as much where the value is more than two spacings.
  double tolerance = 1e-3;
  /// Asked before every sweep, from the calling thread; false ends the solve there. May be empty.
  std::function<bool()> go_on;
  MemoryLimit* memory = nullptr;  ///< Of field and constraints; may be null.
};

struct ObstacleSolution {
  int sweeps = 0;
  std::size_t moving_blocks = 0;  ///< That did not come to rest; 0: converged.
};

/// Makes the free nodes of the active blocks discretely harmonic, or as little above as their
/// floors demand: the obstacle problem  min sum |grad f|^2, f >= floor, by projected successive
/// over-relaxation in red-black order. `constraints` has one entry per node in the order of the
/// field's blocks. Border blocks stay as they are. Blocks that rest are left out of the sweeps.
ObstacleSolution solve_obstacle_problem(SparseField& field,
                                        std::span<const NodeConstraint> constraints,
                                        const ObstacleSolverOptions& options);

}  // namespace relief::fusion
