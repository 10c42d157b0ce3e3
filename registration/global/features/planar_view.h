#pragma once

#include <vector>

#include <Eigen/Core>

#include "registration/surface/view_surface.h"

namespace relief::registration {

/// The flat faces of a view, in its frame.
struct FlatFaces {
  struct Face {
    Eigen::Vector3d point, normal;
  };
  std::vector<Face> faces;  ///< The largest first.
  double fraction = 0.0;    ///< The part of the view's samples that noise alone parts from them.

  /// Whether a point is farther than `distance` from the planes of all faces.
  bool is_off_plane(const Eigen::Vector3d& point, double distance) const;
};

/// Samples so far from all faces stand clear of them [sample spacings]: edges are rounded by a few,
/// and calibrations bend faces.
inline constexpr double kClearOfFaces = 10.0;

/// Prisms show four faces at once.
inline constexpr int kFacesOfAPrism = 4;

/// At most `count` planes, found greedily. A view of a box consists of three.
FlatFaces find_flat_faces(const ViewSurface& view, int count = kFacesOfAPrism);

/// Whether a view shows hardly more than these faces: corners and edges of boxes and prisms, which
/// look alike wherever faces meet at equal angles.
bool is_mostly_planar(const FlatFaces& view);

/// Whether faces are so much of a view that they decide how well a pose fits.
bool planes_dominate(const FlatFaces& view);

/// Views of which one plane is most, as the plate of a turntable or a wall, without it: with the
/// samples alone that stand clear of the plane, where these are enough to tell a pose. The plane
/// fits wherever it is moved in itself, and outweighs what decides. Other views are whole. Empty
/// where all are.
std::vector<ViewSurface> without_dominant_planes(const std::vector<ViewSurface>& views);

}  // namespace relief::registration
