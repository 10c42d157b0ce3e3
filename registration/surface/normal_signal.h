#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/grid.h"
#include "scan/surface/packed_normals.h"

namespace relief::registration {

/// A normal interpolated between pixels and how it changes from pixel to pixel.
struct NormalSample {
  Eigen::Vector3d normal;                ///< Unit, view frame.
  Eigen::Matrix<double, 3, 2> by_pixel;  ///< Derivatives by u and v [1/pixel].
};

/// The normal map of a view as a signal on its surface, at full resolution and coarser ones: cells
/// of level k are means over 2^k x 2^k pixels.
class NormalSignal {
 public:
  NormalSignal() = default;
  /// `normals` are unit vectors, NaN where there is none.
  explicit NormalSignal(const Grid<Eigen::Vector3f>& normals);

  /// How many a grid of that size has: coarser levels end where cells would be larger than 16
  /// pixels or the level smaller than 4.
  static int levels_of(int width, int height);

  bool empty() const { return levels_.empty(); }
  int levels() const { return static_cast<int>(levels_.size()); }  ///< 0: no signal.

  /// The signal at fractional pixel coordinates of level 0: values bilinear, derivatives central
  /// differences, bilinear too. Their white noise is then uncorrelated with that of the value, and
  /// no place between the pixels attracts. Nothing unless all twelve cells around have normals.
  std::optional<NormalSample> at(const Eigen::Vector2d& pixel, int level) const;

 private:
  std::vector<PackedNormals> levels_;
};

}  // namespace relief::registration
