#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

#include "relief/scan/range_view.h"
#include "scan/base/memory/paged_array.h"
#include "scan/surface/observation_weights.h"

namespace relief::fusion {

/// One sample of a view as merging needs it: numbers side by side, to be interpolated in one loop.
struct SurfacePixel {
  std::array<float, 3> point;   ///< View frame, relative to the centre.
  float weight;                 ///< See observation_weights.
  std::array<float, 3> normal;  ///< Unit, facing the sensor.
  float border;                 ///< Distance to the silhouette [pixels].
};

/// What a sample is part of.
enum SurfaceMark : std::uint8_t {
  kQuad = 1,            ///< This, the right, the lower and the lower right sample are one surface.
  kCorner = 2,          ///< The sample belongs to some quad.
  kNoisyQuad = 4,       ///< A quad with a noisy sample: it tells only which space is empty.
  kMeasuredCorner = 8,  ///< The sample belongs to some quad that tells where the surface is.
};

struct PagedSurfaceOptions {
  ObservationWeightOptions weights;
  /// Patches of fewer connected samples are taken for stray measurements and left out.
  int smallest_patch = 20;
  MemoryLimit* memory = nullptr;  ///< Of the surface's pixels; may be null.
};

/// A RangeSurface as merging asks it most often: without its view, its samples as floats side by
/// side, in files under a limit of memory. A crop of the view's grid to where there are quads.
struct PagedSurface {
  PagedGrid<SurfacePixel> pixels;  ///< Empty when the view has no quad. Zeros but at corners.
  PagedGrid<std::uint8_t> marks;   ///< Of the same samples: SurfaceMark, added up.
  PagedGrid<Colour> colours;       ///< Of the same samples; empty when the view has none.
  int first_u = 0, first_v = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< View frame.
  double spacing = 0.0;  ///< Median distance between connected neighbours [unit].
  /// Robust standard deviation of the positions along the normal [unit], from how far each sample
  /// is off the mean of its four neighbours; curvature makes it err on the large side.
  double noise = 0.0;

  /// Places of the measured samples that belong to no quad, relative to the centre.
  PagedArray<std::array<float, 3>> scattered;
  std::size_t flying = 0;  ///< Samples left out as flying_samples tells.
  std::size_t filled = 0;  ///< Samples interpolated in small gaps: fill_small_gaps.
  /// Samples whose noise is more than the spacing and kLargestNoiseRatio times the typical noise:
  /// along the measured normal, else along the ray.
  std::size_t noisy = 0;

  bool quad(int u, int v) const { return marks(u, v) & kQuad; }
  bool corner(int u, int v) const { return marks(u, v) & kCorner; }
  bool noisy_quad(int u, int v) const { return marks(u, v) & kNoisyQuad; }
  bool measured_corner(int u, int v) const { return marks(u, v) & kMeasuredCorner; }
  /// The place of a sample, relative to the centre.
  Eigen::Vector3d offset(int u, int v) const {
    return Eigen::Map<const Eigen::Vector3f>(pixels(u, v).point.data()).cast<double>();
  }
};

/// Normals are the measured ones where there are any, else those of the measured surface. Samples
/// without confidence and flying samples are left out, and small gaps are filled: a filled sample
/// weighs as much as those it is interpolated from.
PagedSurface surface_of(const RangeView& view, const PagedSurfaceOptions& options);

}  // namespace relief::fusion
