#include "registration/posegraph/pose_step.h"

#include <cstddef>

#include <Eigen/Geometry>

namespace relief::registration {

Eigen::Vector3d common_centre(const std::vector<const ViewSurface*>& surfaces,
                              const std::vector<RigidMotion>& world_from_view) {
  const Eigen::Vector3d first = world_from_view.front() * surfaces.front()->centre();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    offset += world_from_view[i] * surfaces[i]->centre() - first;
  return first + offset / static_cast<double>(surfaces.size());
}

RigidMotion moved(const RigidMotion& world_from_view, const RigidTangent& tangent,
                  const Eigen::Vector3d& centre) {
  RigidMotion centred = world_from_view;
  centred.translation() -= centre;
  RigidMotion result = motion_from_tangent(tangent) * centred;
  result.linear() = Eigen::Quaterniond(result.linear()).normalized().toRotationMatrix();
  result.translation() += centre;
  return result;
}

RigidTangent tangent_at(const RigidMotion& motion, const Eigen::Vector3d& centre) {
  const Eigen::AngleAxisd turn(motion.linear());
  RigidTangent tangent;
  tangent << turn.angle() * turn.axis(), motion * centre - centre;
  return tangent;
}

Matrix6d tangents_about(const Eigen::Vector3d& point_from_centre) {
  Matrix6d change = Matrix6d::Identity();
  const Eigen::Vector3d& d = point_from_centre;
  change.bottomLeftCorner<3, 3>() << 0.0, d.z(), -d.y(), -d.z(), 0.0, d.x(), d.y(), -d.x(), 0.0;
  return change;
}

}  // namespace relief::registration
