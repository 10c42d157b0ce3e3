#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "scan/io/clouds/cloud_rays.h"
#include "scan/io/clouds/files/point_cloud_file.h"

namespace relief {

/// The side from which a cloud was seen, as far as its points tell.
struct CloudDirection {
  CloudRays rays;
  double hidden_fraction = 0.0;  ///< Of the points, that others hide or whose normals are averted.
  std::string side;              ///< What the side follows from, for the user.
  bool side_known = true;        ///< False where nothing tells on which side the sensor is.
  /// Whether the points lie all around the origin of the frame and are not seen from it here.
  bool around_origin = false;
};

/// The points of a cloud that a search looks at: all, or an even choice of at most `most`.
std::vector<std::size_t> some_points(std::size_t count, std::size_t most);

/// Median distance of points to their nearest neighbours [unit]; 0 when all are at one place.
double nearest_spacing(const std::vector<Eigen::Vector3d>& points);

/// Finds parallel rays that meet each surface once. Directions all over the sphere and the
/// principal axes are tried on cells of the points' spacing, and the best is refined: fewest points
/// behind others, then the largest area of the picture. The sensor is on the side that normals
/// face (those of faces, else those of the points). Without normals, parallel rays see as much from
/// both sides, and either may be returned.
///
/// Rays from the origin of the frame are preferred where the points lie in front of it within a
/// pinhole's field of view and hide each other no more than in the best direction: depth cameras
/// leave their clouds so. In a wider field of view, as of lidars that do not turn, they must hide
/// each other half as much, unless missing samples of the file are at the origin. So are they where
/// the points lie all around the origin and hide each other less than along any direction, as from
/// a scanner that stands in its surroundings, or lie on the rings of a lidar (on_lidar_rings): seen
/// from above, streets hide hardly a point.
CloudDirection find_direction(const PointCloudFile& cloud);

/// The fraction of the points that lie behind others on these rays, or whose normals are averted.
double hidden_fraction(const PointCloudFile& cloud, const CloudRays& rays);

}  // namespace relief
