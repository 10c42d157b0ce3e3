#pragma once

#include <cstddef>
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

}  // namespace relief::evaluation
