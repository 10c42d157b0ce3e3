#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "hybrid/noise.h"
#include "hybrid/slope_constraints.h"
#include "hybrid/view_solver.h"
#include "scan/discontinuities.h"
#include "scan/progress.h"
#include "scan/range_view.h"
#include "scan/result.h"

namespace relief {

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
  /// replacement of single wild normals either.
  int robust_rounds = 5;

  Solver solver = Solver::kMultigrid;
  double tolerance = 1e-6;   ///< Error of the displacements by the solver, relative.
  int max_iterations = 500;  ///< Of conjugate gradients, per solve.
  /// Find the standard deviation of every refined sample.
  bool deviation = true;
  std::uint64_t seed = 1;  ///< Of the simulated errors from which these deviations follow.
  DiscontinuityOptions discontinuities;
  int threads = 0;  ///< 0: one per core. The result does not depend on it.
};

enum class RefineStatus {
  kRefined,
  kNoNormals,     ///< No two neighbouring samples have normals: the view is as measured.
  kNoConfidence,  ///< No sample has positive confidence: the view is as measured.
  kNoNoise,       ///< Too few samples to estimate the noise, none given: the view is as measured.
  /// Ranges and normals contradict each other over many samples by more than their errors, as where
  /// the normals are wrong: the view is as measured.
  kContradiction,
  kNotConverged,  ///< The solver gave up; the view is its last iterate.
  kSolverFailed,  ///< The system could not be factorised: the view is as measured.
};
std::string_view to_string(RefineStatus status);

struct RefinedView {
  RangeView view;  ///< Range refined; normals corrected; deviations set; all else as given.
  RefineStatus status = RefineStatus::kRefined;
  double sigma_position = 0.0;       ///< Used [unit].
  double sigma_normal = 0.0;         ///< Used [rad].
  double lambda = 0.0;               ///< The same ratio in the published method's terms.
  double bias_rms = 0.0;             ///< RMS of the bias that was found [rad]; 0 unless kLatent.
  double rms_change = 0.0;           ///< Of the refined samples along their rays [unit].
  std::size_t refined = 0;           ///< Samples that normals constrain.
  std::size_t kept = 0;              ///< Samples that keep their measured range.
  std::size_t flying = 0;            ///< Samples that hang in the air: taken away.
  std::size_t filled = 0;            ///< Samples of `view` in small gaps: not measured.
  std::size_t replaced_normals = 0;  ///< Wild normals replaced by those around them.
  std::size_t turned_normals = 0;    ///< Normals of patches that the ranges contradict.
  int rounds = 0;                    ///< Linear systems solved.
  int iterations = 0;                ///< Steps of the linear solver, all rounds together.
  double seconds = 0.0;
};

/// Refines the range of a view with its measured normals (Nehab et al. 2005; equations (H2) to
/// (H5)). Samples without normals, or whose neighbours have none, keep their range; flying samples
/// are taken away and small gaps filled (scan/filled_view.h). The rounding of the ranges and noise
/// that changes over the view are allowed for (scan/range_noise.h). Errors:
/// kBadInput for an option out of range, kInterrupted when `progress` asks to stop.
Result<RefinedView> refine_view(const RangeView& view, const RefineOptions& options = {},
                                const Progress& progress = {});

}  // namespace relief
