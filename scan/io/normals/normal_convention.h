#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "scan/io/project/view_spec.h"

namespace relief {

/// What the three stored components of a normal mean.
struct NormalConvention {
  /// A signed permutation: the stored components in the axes of `space`. For an image in camera
  /// space these are the sensor's right, down and forward, for a grid file the axes of the file.
  Eigen::Matrix3d space_from_stored = Eigen::Matrix3d::Identity();
  NormalSpace space = NormalSpace::kCamera;

  bool operator==(const NormalConvention&) const = default;
};

/// What holds the normals decides which conventions make sense.
enum class NormalFileKind { kImage, kGrid };

/// `opencv` or `opengl` components in camera or world space.
NormalConvention named_convention(NormalAxes axes, NormalSpace space);

/// All conventions that a file may follow. Camera space of images: every sign, with x and y in
/// their order, swapped, or x and z swapped (channels stored as BGR). Otherwise all 48 signed
/// permutations, since the frame of a file or world may lie in any way.
const std::vector<NormalConvention>& all_conventions(NormalFileKind source);

/// How many stored axes mean something else; 3 more for another space.
int distance(const NormalConvention& a, const NormalConvention& b);

/// For the user: `axes opengl, space camera`, or what each axis is, such as
/// `x right, y up, z forward, space camera`.
std::string to_string(const NormalConvention& convention, NormalFileKind source);

}  // namespace relief
