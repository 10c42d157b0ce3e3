#pragma once

#include "registration/pairwise/degenerate_directions.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// Sums of a weighted least-squares problem in one rigid motion: of w j j^T, and of w r j, half the
/// gradient, over residuals r with derivatives j.
struct NormalEquations {
  Matrix6d matrix = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();

  void add(const Vector6d& j, double residual, double weight) {
    matrix.noalias() += weight * j * j.transpose();
    gradient += weight * residual * j;
  }
};

}  // namespace relief::registration
