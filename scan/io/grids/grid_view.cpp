#include "scan/io/grids/grid_view.h"

#include <cmath>
#include <string>

#include "scan/io/files/unit_quaternion.h"
#include "scan/io/grids/cameras/camera_fit.h"
#include "scan/io/grids/cameras/grid_camera.h"

namespace relief {

namespace {

// Of the length of a unit vector of floats: normalising takes 3.5 roundings of 2^-24, 2.1e-7.
constexpr double kRounding = 3e-7;

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

Result<void> check_size(const std::string& what, int width, int height, const GridFile& grid) {
  if (width == grid.points.width() && height == grid.points.height()) return {};
  return Error{ErrorKind::kBadInput, what + " is " + size_text(width, height) + ", but the grid " +
                                         size_text(grid.points.width(), grid.points.height())};
}

template <typename T>
Result<void> check_size(const std::string& what, const Grid<T>& values, const GridFile& grid) {
  return values.empty() ? Result<void>() : check_size(what, values.width(), values.height(), grid);
}

Result<void> check(const GridFile& grid, const std::optional<Camera>& camera) {
  if (grid.points.empty()) return Error{ErrorKind::kBadInput, "the grid has no points"};
  if (grid.points.height() == 1)
    return Error{ErrorKind::kBadInput,
                 "the points are not organized: a grid has more than one row; keep the sensor's "
                 "width and height"};
  if (auto size = check_size("the grid of normals", grid.normals, grid); !size) return size;
  if (auto size = check_size("the grid of confidences", grid.confidence, grid); !size) return size;
  if (auto size = check_size("the grid of colours", grid.colours, grid); !size) return size;
  if (!camera) return {};
  return check_size("the camera", camera->width(), camera->height(), grid);
}

// NaN unless it is a direction that faces the sensor.
Eigen::Vector3f usable_normal(const Eigen::Vector3f& normal, const Ray& ray) {
  const Eigen::Vector3d vector = normal.cast<double>();
  const double length = vector.norm();
  if (std::abs(length - 1.0) < kRounding && vector.dot(ray.direction) < 0.0) return normal;
  if (length >= 0.5 && length <= 1.5 && vector.dot(ray.direction) < 0.0)
    return (vector / length).cast<float>();
  return Eigen::Vector3f::Constant(static_cast<float>(kNoSample));
}

}  // namespace

void set_usable_normals(const Grid<Eigen::Vector3f>& given, RangeView& view) {
  if (given.empty()) return;
  const auto no_normal = Eigen::Vector3f::Constant(static_cast<float>(kNoSample));
  view.normals = Grid<Eigen::Vector3f>(view.width(), view.height(), no_normal);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v))
        view.normals(u, v) = usable_normal(given(u, v), view.camera.ray(u, v));
}

Result<RangeView> view_from_grid(const GridFile& grid, const std::optional<Camera>& camera) {
  if (auto sound = check(grid, camera); !sound) return sound.error();
  GridCamera fitted = camera_through_points(grid.points, camera ? *camera : fit_camera(grid).model);
  RangeView view;
  view.camera = std::move(fitted.camera);
  view.range = std::move(fitted.range);
  if (view.sample_count() == 0)
    return Error{ErrorKind::kUnsolvable, "no point of the grid is finite"};
  set_usable_normals(grid.normals, view);
  view.confidence = grid.confidence;
  for (float& value : view.confidence)
    if (!(value >= 0.0f) || !std::isfinite(value)) value = 0.0f;
  view.colours = grid.colours;
  if (!grid.world_from_view) return view;
  view.world_from_view = *grid.world_from_view;
  view.pose = PoseKind::kGuess;
  return view;
}

Result<std::optional<RigidMotion>> pose_from_viewpoint(const Eigen::Vector3f& origin,
                                                       const Eigen::Quaternionf& orientation) {
  const Eigen::Quaterniond rotation = orientation.cast<double>();
  if (!origin.allFinite() || !(std::abs(rotation.norm() - 1.0) < kUnitQuaternion))
    return Error{ErrorKind::kBadInput, "the viewpoint is not a position and a unit quaternion"};
  RigidMotion pose = RigidMotion::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = origin.cast<double>();
  if (pose.matrix() == Eigen::Matrix4d::Identity()) return std::optional<RigidMotion>();
  return std::optional(pose);
}

}  // namespace relief
