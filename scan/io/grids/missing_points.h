#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace relief {

/// What stood for missing samples.
struct MissingPoints {
  bool at_origin = false;          ///< So the origin is where the sensor was.
  std::vector<std::string> notes;  ///< For the user, one for each kind.
};

/// Points that stand for missing samples become NaN: several at exactly the origin, since a surface
/// has but one point there, and those at the depth (the size of z) that invalid_depth_value()
/// names, which depth cameras write as 65.535.
MissingPoints invalidate_missing_points(std::span<Eigen::Vector3d> points);

/// The same for the corners of a mesh, which may meet at the origin and share any depth but the
/// largest of 16 bits.
MissingPoints invalidate_missing_corners(std::span<Eigen::Vector3d> points);

/// Whether any of the normals of a file is a direction: finite and not zero. PCL's points with
/// normals are written with zeros where nobody has computed them.
bool hold_directions(std::span<const Eigen::Vector3f> normals);

/// For the user, of normals that are not.
inline constexpr const char* kZeroNormalsNote = "the normals of the file are all zero: not used";

}  // namespace relief
