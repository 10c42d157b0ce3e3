#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "relief/hybrid/refine_options.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief::hybrid {

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
/// are taken away and small gaps filled. The rounding of the ranges and
/// noise that changes over the view are allowed for (relief/scan/range_noise.h).
/// Errors: kBadInput for an option out of range, kInterrupted.
Result<RefinedView> refine_view(const RangeView& view, const RefineOptions& options = {},
                                const Context& context = {});

}  // namespace relief::hybrid
