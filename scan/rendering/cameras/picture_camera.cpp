#include "relief/rendering/picture_camera.h"

#include <Eigen/Geometry>

namespace relief::rendering {

Ray PictureCamera::ray(double x, double y) const {
  const Ray ray = camera.ray_at(first.x() + step.x() * x, first.y() + step.y() * y);
  return {world_from_camera * ray.origin, world_from_camera.linear() * ray.direction};
}

bool PictureCamera::rays_start_at_sensor() const {
  return camera.model() == Camera::Model::kPinhole || camera.model() == Camera::Model::kPinholeGl ||
         camera.model() == Camera::Model::kSpherical;
}

Eigen::Matrix3d PictureCamera::picture_axes() const {
  const double x = 0.5 * (width - 1), y = 0.5 * (height - 1);
  const Ray middle = ray(x, y);
  const Eigen::Vector3d towards = -middle.direction.normalized();
  // One range away from both, so that it serves rays that start at one point and parallel ones.
  const Eigen::Vector3d step_right = ray(x + 0.5, y).at(1.0) - ray(x - 0.5, y).at(1.0);
  const Eigen::Vector3d step_down = ray(x, y + 0.5).at(1.0) - ray(x, y - 0.5).at(1.0);
  const Eigen::Vector3d right = (step_right - towards.dot(step_right) * towards).normalized();
  Eigen::Vector3d up = towards.cross(right);
  if (up.dot(step_down) > 0.0) up = -up;
  Eigen::Matrix3d axes;
  axes << right.transpose(), up.transpose(), towards.transpose();
  return axes;
}

}  // namespace relief::rendering
