#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "relief/scan/grid.h"

namespace relief {

struct NormalEvidence;

/// Where a normal map lies that its file has elsewhere: mirrored first, then moved.
struct MapPlacement {
  bool mirrored_across = false;  ///< Left to right.
  bool mirrored_down = false;    ///< Top to bottom.
  int right = 0, down = 0;       ///< How far the map has to move [pixels].
  double median = 0.0;           ///< Angle to the depth there [rad], in the best convention.
};

/// `mirrored left to right and moved by 8 pixels to the left and 3 down`.
std::string to_string(const MapPlacement& placement);

/// The placement that lays a map on the depth of its view far better than it lies as stored: by
/// half the difference between neighbouring windows, in which a bias of the normals cancels, and by
/// the angles. `evidence` has the patches of the view and what conventions are possible; `stored`
/// are the directions of the map (NaN: none). Maps are moved by up to some ten windows. Nothing
/// where the map lies well, and where noise, little relief or another depth tell nothing.
std::optional<MapPlacement> find_placement(const NormalEvidence& evidence,
                                           const Grid<Eigen::Vector3f>& stored);

}  // namespace relief
