#pragma once

#include <string>

#include <Eigen/Core>

#include "relief/scan/rigid_motion.h"

namespace relief {

/// What the rotations of poses may be.
enum class StoredRotation {
  kAsRead,
  kInverse,           ///< Of the inverse pose; the translation is of the pose.
  kQuaternionWFirst,  ///< Quaternions qw qx qy qz were read as qx qy qz qw.
};

/// What a program may mean by the poses that it writes, other than world_from_view of cameras with
/// x right, y down and z forward.
struct PoseConvention {
  double unit = 1.0;             ///< Of the translations [unit of the views].
  bool view_from_world = false;  ///< The inverse is stored.
  /// Of the stored camera from those of the view: a signed permutation. With determinant -1 camera
  /// and world are left-handed.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  StoredRotation rotation = StoredRotation::kAsRead;
  /// Poses are those of a body that the sensor is fixed to, as of a robot; axes are the body's.
  RigidMotion body_from_view = RigidMotion::Identity();

  bool as_given() const {
    return unit == 1.0 && !view_from_world && axes.isIdentity(0.0) &&
           rotation == StoredRotation::kAsRead && !has_body();
  }
  bool has_body() const { return !body_from_view.matrix().isIdentity(0.0); }
  /// world_from_view of a pose in this convention. Of a left-handed world y is reversed.
  RigidMotion world_from_view(const RigidMotion& pose) const;
  /// In words, as `view_from_world with x right, y up, z back`.
  std::string describe() const;
};

/// Whether a view that looks at `centre` (its own frame) only rolls about its line of sight there
/// from another one. It sees nothing new, so few scans are made like that. In a wrong convention
/// views from all round a turntable lie on each other like that, and any round object agrees.
bool only_rolls(const RigidMotion& other_from_view, const Eigen::Vector3d& centre);

/// Those of OpenGL: x right, y up, z back.
Eigen::Matrix3d opengl_axes();

}  // namespace relief
