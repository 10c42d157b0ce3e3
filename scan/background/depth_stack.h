#pragma once

#include <cstddef>
#include <vector>

#include "relief/scan/camera.h"
#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "scan/grid/range_noise.h"

namespace relief {

/// The depths of views whose cameras have the same rays in the camera's frame, pixel by pixel.
struct DepthStack {
  Camera camera;                    ///< Of the first view; its rays serve all of them.
  double range = 0.0;               ///< Median of the first view.
  std::vector<std::size_t> views;   ///< Which views these are.
  std::vector<Grid<float>> depths;  ///< Distance along the common ray [unit]; NaN: no sample.
  std::vector<RangeNoise> noises;   ///< Of the views.
  /// How far two depths of one point that stands still may be apart [unit]: five standard
  /// deviations of the noise and one sample spacing.
  Grid<float> tolerance;

  std::size_t size() const { return views.size(); }
};

/// Whether two cameras count as one: their images have the same size, and their rays differ by less
/// than half a pixel at this parameter of the rays.
bool same_rays(const Camera& a, const Camera& b, double range);

/// The depths of a view along the rays of `camera`, which are its own as far as same_rays() tells.
Grid<float> depths_of(const RangeView& view, const Camera& camera);

/// Sorts views by camera.
std::vector<DepthStack> stack_depths(const std::vector<const RangeView*>& views);

}  // namespace relief
