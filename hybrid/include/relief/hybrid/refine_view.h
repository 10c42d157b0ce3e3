#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "relief/scan/context.h"
#include "relief/scan/discontinuities.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

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
  /// such that bias and noise of the normals cross where positions and normals do, and larger where
  /// the first solution shows that the bias is rough (H18). A given one is the same everywhere.
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

enum class RefineStatus {
  kRefined,
  kNoNormals,     ///< No two neighbouring samples have normals: the view is as measured.
  kNoConfidence,  ///< No sample has positive confidence: the view is as measured.
  kNoiseUnknown,  ///< Too few samples to estimate the noise, none given: the view is as measured.
  /// Ranges and normals contradict each other over many samples by more than their errors, as where
  /// the normals are wrong: the view is as measured.
  kContradiction,
  kNotConverged,  ///< The solver gave up; the view is its last iterate.
  kSolverFailed,  ///< The system could not be factorised: the view is as measured.
};
std::string_view to_string(RefineStatus status);

/// How far ranges deviate from the surface that the measured normals imply, along rows and columns,
/// in one octave of wavelengths (H17): of one sample [unit], if errors were independent.
struct DeviationBand {
  double wavelength = 0.0;  ///< In the middle of the band [samples].
  double measured = 0.0;
  double refined = 0.0;
};

/// What refining did to one view.
struct RefineSummary {
  RefineStatus status = RefineStatus::kRefined;
  /// Used [unit]; of a view that stays as measured what its ranges show, 0 where they do not.
  double sigma_position = 0.0;
  double sigma_normal = 0.0;         ///< Used [rad].
  double lambda = 0.0;               ///< The same ratio in the published method's terms.
  double bias_rms = 0.0;             ///< RMS of the bias that was found [rad]; 0 unless kLatent.
  double rms_change = 0.0;           ///< Of the refined samples along their rays [unit].
  std::size_t refined = 0;           ///< Samples that normals constrain.
  std::size_t kept = 0;              ///< Samples that keep their measured range.
  std::size_t flying = 0;            ///< Samples that hang in the air: taken away.
  std::size_t filled = 0;            ///< Samples of `view` in small gaps: not measured.
  std::size_t replaced_normals = 0;  ///< Wild normals replaced by those around them.
  std::size_t outlier_normals = 0;   ///< Normals of patches that the ranges contradict.
  int rounds = 0;                    ///< Linear systems solved.
  int iterations = 0;                ///< Steps of the linear solver, all rounds together.
  double seconds = 0.0;
  /// By growing wavelength; empty for views that stay as measured.
  std::vector<DeviationBand> spectrum;

  /// Whether the solver gave up or failed.
  bool failed() const {
    return status == RefineStatus::kNotConverged || status == RefineStatus::kSolverFailed;
  }
};

struct RefinedView : RefineSummary {
  RangeView view;  ///< Range refined; normals corrected; deviations set; all else as given.
};

/// Refines the range of a view with its measured normals (Nehab et al. 2005; equations (H2) to
/// (H5)). Samples without normals, or whose neighbours have none, keep their range; flying samples
/// are taken away and small gaps filled. The rounding of the ranges and noise that changes over the
/// view are allowed for (docs/hybrid.md).
/// Errors: kBadInput for an option out of range, kInterrupted.
Result<RefinedView> refine_view(const RangeView& view, const RefineOptions& options = {},
                                const Context& context = {});

/// Refines one view, as refine_view() does.
using RefineOne = std::function<Result<RefinedView>(
    const RangeView& view, const RefineOptions& options, const Context& context)>;

/// Refines all views, several at a time. The memory of the context is that of the whole process: as
/// many views are refined at once as it leaves room for, at least one. With fewer views than
/// threads each view gets several threads. The results are in the order of the views and do not
/// depend on the number of threads, nor on the memory. A view that cannot be refined stays as
/// measured; its status says why. `refine` is called for each view, from several threads at once.
/// Errors: kBadInput for an option out of range, kInterrupted.
Result<std::vector<RefinedView>> refine_views(const std::vector<RangeView>& views,
                                              const RefineOptions& options = {},
                                              const Context& context = {},
                                              const RefineOne& refine = refine_view);

}  // namespace relief::hybrid
