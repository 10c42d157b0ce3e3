#pragma once

#include <optional>

#include "relief/evaluation/error_spectrum.h"
#include "relief/evaluation/view_errors.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/scan_project.h"

namespace relief::evaluation {

/// The errors of all views by spatial frequency along their grids, away from discontinuities.
struct ViewSpectra {
  ErrorSpectrum depth;  ///< Signed length along the ray [unit^2 / (cycle per sample)^2].
  /// The rotations that take true normals to those of the normal maps, as vectors of two components
  /// in the tangent plane [rad^2 / (cycle per sample)^2]. Empty without normal maps.
  ErrorSpectrum map_normals;
  /// The same from the central differences of the true positions to those of the view's positions:
  /// what differences get wrong by themselves cancels.
  ErrorSpectrum position_normals;
  double spacing = 0.0;  ///< Median sample spacing of the true views [unit].
  /// The wavelength [samples] at which the two normal spectra cross: at shorter ones the normal
  /// maps are better than the positions, at longer ones worse. Nothing when they do not cross so.
  std::optional<double> crossing_wavelength;
};

/// Compares each view of `result` with the true view of its name; poses do not matter. True normals
/// are those the truth carries, else the central differences of its positions.
/// `options.edge_pixels` says what is away from discontinuities. Errors as those of evaluate_views.
Result<ViewSpectra> evaluate_spectra(const ScanProject& result, const ScanProject& truth,
                                     const ViewErrorOptions& options = {},
                                     const Context& context = {});

}  // namespace relief::evaluation
