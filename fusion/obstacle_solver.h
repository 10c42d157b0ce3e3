#pragma once

#include <vector>

#include "fusion/sparse_field.h"

namespace relief {

/// What is known at one node of a field.
struct NodeConstraint {
  float floor = 0.0f;  ///< The value is not below this.
  bool fixed = false;  ///< The value stays as it is.
};

struct ObstacleSolverOptions {
  double relaxation = 1.5;  ///< Over-relaxation factor, 1 to below 2.
  int max_sweeps = 60;
  double tolerance = 1e-3;  ///< Stop when no value changes by more than this times the spacing.
  int threads = 0;
};

/// Makes the free nodes of the active blocks discretely harmonic, or as little above as their
/// floors demand: the obstacle problem  min sum |grad f|^2, f >= floor, by projected successive
/// over-relaxation in red-black order. `constraints` has one entry per node in the order of the
/// field's blocks. Border blocks stay as they are. Returns the number of sweeps.
int solve_obstacle_problem(SparseField& field, const std::vector<NodeConstraint>& constraints,
                           const ObstacleSolverOptions& options);

}  // namespace relief
