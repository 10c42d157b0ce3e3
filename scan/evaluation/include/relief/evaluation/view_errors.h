#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "relief/evaluation/error_statistics.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/scan_project.h"

namespace relief::evaluation {

struct ViewErrorOptions {
  /// Samples up to this many pixels (chessboard distance) from the silhouette, a hole, an occlusion
  /// edge of the true view or the border of the grid count as `edge`, the others as `inner`. >= 0.
  int edge_pixels = 2;
};

/// Errors over all samples, away from discontinuities, and at them.
struct SplitStatistics {
  ErrorStatistics all, inner, edge;
};

/// How far one view's samples and normals are from the truth.
struct ViewErrors {
  std::string name;
  /// |d| (t - t_true): length along the ray [unit].
  SplitStatistics depth;
  double depth_bias = 0.0;  ///< Mean of the same with its sign: positive is too far [unit].
  /// Angle to the true normal [degrees] of the normals that the positions have: cross products of
  /// central differences, without any smoothing.
  SplitStatistics position_normals_deg;
  /// Angle between those and the same cross products of the true positions [degrees]: free of what
  /// central differences of exact samples err by, where relief is a few samples long.
  SplitStatistics sampled_normals_deg;
  /// Angle to the true normal [degrees] of the view's normal map; counts are 0 where it has none.
  SplitStatistics map_normals_deg;
  std::size_t missing = 0;  ///< Samples that only the truth has.
  std::size_t extra = 0;    ///< Samples that only the result has; they enter no statistics.
};

struct ViewErrorReport {
  std::vector<ViewErrors> views;       ///< In the order of the result.
  ViewErrors overall;                  ///< All samples of all views together; named `overall`.
  std::vector<std::string> unmatched;  ///< Views of the truth that the result does not have.
};

/// Compares each view of `result` with the true view of its name, sample by sample; poses do not
/// matter. True normals are those the truth carries, else the central differences of its positions.
/// kBadInput when a view has no true view, or the two differ in size or in their rays.
Result<ViewErrorReport> evaluate_views(const ScanProject& result, const ScanProject& truth,
                                       const ViewErrorOptions& options = {},
                                       const Context& context = {});

/// The mean power of errors with spatial frequencies in [low, high).
struct SpectrumBand {
  double low = 0.0, high = 0.0;  ///< [cycles per sample]
  double frequency = 0.0;        ///< Mean of the frequencies in the band [cycles per sample].
  /// Power density [error unit^2 / (cycle per sample)^2], sum of both components: white noise of
  /// variance s^2 per component has s^2 (2 s^2 for two) in every band.
  double density = 0.0;
  /// What the band covers of the plane of frequencies [(cycle per sample)^2]; density times area is
  /// the variance in the band.
  double area = 0.0;
  int tile = 0;           ///< Side of the tiles it was estimated from [samples].
  std::size_t tiles = 0;  ///< How many there were.
  // The relative standard deviation of the density is about 2 / (tile sqrt(tiles area)).
};

/// Bands in ascending order, four to the octave, from two cycles per largest tile to the highest
/// frequency of the grid, sqrt(1/2).
struct ErrorSpectrum {
  std::vector<SpectrumBand> bands;  ///< Empty when no tile fits into the data.
  /// The fraction of samples in any tile, for the smallest and for the largest tiles.
  double finest_coverage = 0.0, coarsest_coverage = 0.0;

  /// The variance in all bands together.
  double variance() const;
};

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
