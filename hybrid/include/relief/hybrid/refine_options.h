#pragma once

#include <cstdint>
#include <optional>

#include "relief/scan/discontinuities.h"

namespace relief::hybrid {

/// How a normal constrains the ranges next to it.
enum class Stencil {
  kCompactEdge,   ///< Equation (H4): one constraint per grid edge, with the normals of both ends.
  kPaperCentral,  ///< Equation (H3): central differences at each sample (Nehab et al. 2005).
};

/// How the normal equations of a view are solved.
enum class Solver {
  /// Conjugate gradients preconditioned by multigrid, for the compact stencil; the central one is
  /// solved by kCholesky.
  kMultigrid,
  kCholesky,  ///< One sparse factorisation: the reference.
};

/// What is done about the low-frequency error of measured normals.
enum class BiasModel {
  kLatent,   ///< Equation (H5): solved for together with the range.
  kTwoStep,  ///< Equation (H1): corrected before the solve (Nehab et al. 2005).
  kNone,     ///< Nothing: the normals are taken as they are.
};

struct RefineOptions {
  Stencil stencil = Stencil::kCompactEdge;
  BiasModel bias = BiasModel::kLatent;

  /// Standard deviation along its ray of a measured range that counts 1 (PositionConfidence)
  /// [unit], > 0. Default: the median of the deviations that the view has, or else estimated.
  std::optional<double> sigma_position;
  /// Standard deviation of a measured normal's slope along one tangent [rad], > 0. Default:
  /// estimated.
  std::optional<double> sigma_normal;
  /// Weight of positions against normals as in the published method, lambda E_p + (1 - lambda) E_n,
  /// in (0, 1); 0.1 there. Replaces sigma_normal: every constraint gets the same weight.
  std::optional<double> lambda;

  /// kLatent: standard deviation of the change of the bias between neighbours [rad], > 0. Default:
  /// such that bias and noise of the normals cross where positions and normals do.
  std::optional<double> sigma_bias_step;
  /// kTwoStep: length of the smoothing kernel [samples], > 0. Default: the wavelength / 2 pi at
  /// which the errors of positions and normals cross.
  std::optional<double> smoothing_scale;

  /// Rounds of reweighting that follow the plain least-squares solve; 0: no robust loss, and no
  /// replacement of single wild normals either. They end when the samples settle: after 3 on the
  /// built-in object (docs/results.md, Refining one view, by size).
  int robust_rounds = 5;

  Solver solver = Solver::kMultigrid;
  /// Error of the displacements by the solver, relative: as close to the direct solver's.
  double tolerance = 1e-6;
  /// Of conjugate gradients, per solve. The hardest masks take 113 (docs/results.md, Steps of the
  /// solver).
  int max_iterations = 500;
  /// Find the standard deviation of every refined sample, from simulated errors that the seed of
  /// the context chooses.
  bool deviation = true;
  DiscontinuityOptions discontinuities;
};

}  // namespace relief::hybrid
