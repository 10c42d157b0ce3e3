#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "hybrid/model/view_problem.h"
#include "hybrid/solver/view_solver.h"

namespace relief::hybrid {

/// The errors of the measurements, whatever weights the terms of (H5) got.
struct MeasurementNoise {
  double sigma_position = 0.0;  ///< Of a range of confidence 1, along the ray [unit].
  double sigma_normal = 0.0;    ///< Of a normal's slope along one tangent [rad].
};

struct DeviationOptions {
  /// Simulated repetitions of the measurement, each one solve; >= 1. With two and averaging, a
  /// deviation is good to about ten percent; the error falls with the root of the number. Measured
  /// for 1, 2 and 4 (docs/results.md, Range standard deviations).
  int probes = 2;
  /// The wavelength / 2 pi at which positions and normals cross [samples]: sets over how many
  /// samples deviations are averaged. 0: they are not. Refining sets it to that of the view.
  double crossover = 8.0;
  /// Of each solve, relative: 0.001 takes 8.1 % of scatter to 7.8 % (there, too).
  double tolerance = 0.1;
  int max_iterations = 500;  ///< Per solve.
  std::uint64_t seed = 1;
};

/// Standard deviation of the refined range of every movable sample along its ray [unit], equations
/// (H10) and (H11). `y` is the solution, with the bias that was found, if any; `solver` must hold
/// `weights`. Empty when a solve does not converge.
Eigen::VectorXf range_deviation(const ViewProblem& problem, const ViewWeights& weights,
                                const MeasurementNoise& noise, const Eigen::VectorXd& y,
                                ViewSolver& solver, const DeviationOptions& options = {});

}  // namespace relief::hybrid
