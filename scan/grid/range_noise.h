#pragma once

#include <cstddef>
#include <string>

#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "scan/grid/range_quantisation.h"

namespace relief {

/// Samples with so many times the noise of a typical one count for less than a hundredth of it:
/// they tell which space is empty, not where a surface is. Depth cameras return ranges at ten times
/// the distance that they are made for, with a hundred times the noise.
inline constexpr double kLargestNoiseRatio = 10.0;

/// The errors of a view's ranges from sample to sample, estimated from the ranges alone. Smooth
/// errors and errors that many neighbouring samples share are not seen.
struct RangeNoise {
  RangeQuantisation quantisation;
  /// Standard deviation of the position of a typical sample along its ray [unit]: at least its step
  /// / sqrt(12). 0 when unknown.
  double sigma = 0.0;
  /// The same of each pixel, where it changes over the view by more than chance; of pixels without
  /// a sample, too. Empty where it is the same everywhere.
  Grid<float> map;
  double step = 0.0;            ///< Of a typical sample, by rounding [unit]; 0: none.
  std::size_t differences = 0;  ///< Used; a few hundred give sigma to a tenth.

  bool known() const { return sigma > 0.0; }
  /// Whether ranges are rounded by more than their noise: then errors of neighbours are alike.
  bool rounded() const { return step > sigma; }
  double sigma_at(int u, int v) const { return map.empty() ? sigma : double{map(u, v)}; }
  /// Whether a sample has more than kLargestNoiseRatio times the typical noise.
  bool is_too_noisy(int u, int v) const { return sigma_at(u, v) > kLargestNoiseRatio * sigma; }
};

/// Robust: a tenth of wild samples, occlusion edges and missing samples do no harm. Needs
/// neither normals nor edges. The same for any number of threads.
RangeNoise estimate_range_noise(const RangeView& view);

/// In words, such as `range in steps of 1 mm; noise 0.3 mm, 5.0 times larger at the left than at
/// the right`. `unit` may be empty.
std::string describe(const RangeNoise& noise, const RangeView& view, const std::string& unit);

}  // namespace relief
