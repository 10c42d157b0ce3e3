#include "scan/views/pose_convention.h"

#include <cstdio>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace relief {

namespace {

bool is_left_handed(const Eigen::Matrix3d& axes) { return axes.determinant() < 0.0; }

// Where x, y and z of the stored camera point to: `x right, y down, z forward`.
std::string directions(const Eigen::Matrix3d& axes) {
  constexpr const char* kForth[] = {"right", "down", "forward"};
  constexpr const char* kBack[] = {"left", "up", "back"};
  std::string text;
  for (int i = 0; i < 3; ++i) {
    Eigen::Index along = 0;
    axes.row(i).cwiseAbs().maxCoeff(&along);
    text += std::string(i == 0 ? "" : ", ") + "xyz"[i] + " " +
            (axes(i, along) > 0.0 ? kForth : kBack)[along];
  }
  return text;
}

Eigen::Matrix3d meant_rotation(const Eigen::Matrix3d& read, StoredRotation stored) {
  switch (stored) {
    case StoredRotation::kAsRead:
      break;
    case StoredRotation::kInverse:
      return read.transpose();
    case StoredRotation::kQuaternionWFirst: {
      const Eigen::Quaterniond q(read);
      return Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()).toRotationMatrix();
    }
  }
  return read;
}

}  // namespace

RigidMotion PoseConvention::world_from_view(const RigidMotion& pose) const {
  RigidMotion read = pose;
  read.linear() = meant_rotation(read.linear(), rotation);
  read.translation() *= unit;
  if (view_from_world) read = read.inverse();
  read.linear() = read.linear() * axes;
  if (!is_left_handed(axes)) return read * body_from_view;
  const Eigen::Vector3d mirror(1.0, -1.0, 1.0);
  read.linear() = mirror.asDiagonal() * read.linear();
  read.translation() = mirror.asDiagonal() * read.translation();
  return read * body_from_view;
}

std::string PoseConvention::describe() const {
  std::string text = view_from_world ? "view_from_world" : "world_from_view";
  if (!axes.isIdentity(0.0)) text += " with " + directions(axes);
  if (is_left_handed(axes)) text += " in a left-handed world (its y is reversed)";
  if (rotation == StoredRotation::kInverse) text += ", rotations those of the inverse";
  if (rotation == StoredRotation::kQuaternionWFirst) text += ", quaternions as qw qx qy qz";
  char times[40];
  std::snprintf(times, sizeof times, ", translations times %g", unit);
  if (unit != 1.0) text += times;
  char body[160];
  std::snprintf(body, sizeof body,
                ", of a body that the sensor is fixed to: turned by %.3g deg and %.3g away from it",
                rotation_angle(body_from_view) * 180.0 / std::numbers::pi,
                body_from_view.translation().norm());
  if (has_body()) text += body;
  return text;
}

bool only_rolls(const RigidMotion& other_from_view, const Eigen::Vector3d& centre) {
  // A turn and a shift [distance of the centre], as of two guesses that are 3 degrees off each.
  constexpr double kReach = 0.1;
  const double reach = kReach * centre.norm();
  return other_from_view.translation().norm() <= reach &&
         (other_from_view * centre - centre).norm() <= reach &&
         rotation_angle(other_from_view) > kReach;
}

Eigen::Matrix3d opengl_axes() { return Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal(); }

}  // namespace relief
