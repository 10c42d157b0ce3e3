#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "relief/rendering/picture_camera.h"

namespace relief::rendering {

namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

// From a frame in which `up` is z.
Eigen::Matrix3d world_from_upright(const Eigen::Vector3d& up) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up).toRotationMatrix();
}

// Columns: right, down, forward of the camera, in the world.
Eigen::Matrix3d camera_axes(const ViewingDirection& direction, const Eigen::Vector3d& up) {
  const double azimuth = radians(direction.azimuth_deg),
               elevation = radians(direction.elevation_deg);
  const Eigen::Vector3d forward(-std::sin(azimuth) * std::cos(elevation),
                                std::cos(azimuth) * std::cos(elevation), -std::sin(elevation));
  const Eigen::Vector3d right(std::cos(azimuth), std::sin(azimuth), 0.0);
  Eigen::Matrix3d axes;
  axes << right, forward.cross(right), forward;
  return world_from_upright(up) * axes *
         Eigen::AngleAxisd(radians(direction.roll_deg), Eigen::Vector3d::UnitZ());
}

// Of the bounding box; the origin for a mesh without vertices.
Eigen::Vector3d middle_of(const TriangleMesh& mesh) {
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  return box.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(box.center());
}

// Half the picture at range 1, without the margin.
Eigen::Vector2d half_size(const FramingOptions& options) {
  const double longer = std::max(options.width, options.height);
  const double half =
      options.field_of_view_deg > 0.0 ? std::tan(0.5 * radians(options.field_of_view_deg)) : 1.0;
  return (1.0 - 2.0 * options.margin) * half / longer *
         Eigen::Vector2d(options.width, options.height);
}

// How far the mesh reaches beyond the planes through the middle that bound the picture right, left,
// below and above. Parallel ones for an orthographic camera.
struct Reach {
  Eigen::Array2d after = Eigen::Array2d::Constant(-1e300);
  Eigen::Array2d before = Eigen::Array2d::Constant(-1e300);
  double front = -1e300;  // Towards the viewer.
};

Reach reach_of(const TriangleMesh& mesh, const Eigen::Matrix3d& axes, const Eigen::Vector3d& middle,
               const FramingOptions& options) {
  const Eigen::Array2d slope =
      options.field_of_view_deg > 0.0 ? half_size(options).array() : Eigen::Array2d::Zero().eval();
  Reach reach;
  for (const auto& vertex : mesh.vertices) {
    const Eigen::Vector3d p = axes.transpose() * (vertex - middle);
    reach.after = reach.after.max(p.head<2>().array() - slope * p.z());
    reach.before = reach.before.max(-p.head<2>().array() - slope * p.z());
    reach.front = std::max(reach.front, -p.z());
  }
  if (mesh.vertices.empty()) reach.after = reach.before = Eigen::Array2d::Ones();
  return reach;
}

// From the middle to the camera of a pinhole; half the side of a picture with half_size 1 else.
double distance_for(const Reach& reach, const FramingOptions& options) {
  const Eigen::Array2d needed = 0.5 * (reach.after + reach.before) / half_size(options).array();
  return std::max(needed.maxCoeff(), 1e-12);
}

// A camera whose axis passes `middle` at `shift` to the right and below.
PictureCamera camera_at(const Eigen::Matrix3d& axes, const Eigen::Vector3d& middle,
                        const Eigen::Array2d& shift, double distance, double front,
                        const FramingOptions& options) {
  PictureCamera picture;
  picture.width = options.width;
  picture.height = options.height;
  const double longer = std::max(options.width, options.height);
  const double cx = 0.5 * (options.width - 1), cy = 0.5 * (options.height - 1);
  double back = distance;
  if (options.field_of_view_deg > 0.0) {
    const double focal = 0.5 * longer / std::tan(0.5 * radians(options.field_of_view_deg));
    picture.camera = Camera::pinhole(options.width, options.height, {focal, focal, cx, cy});
  } else {
    const double pixel = 2.0 * distance / longer;
    back = front + distance;
    picture.camera =
        Camera::orthographic(options.width, options.height, {-cx * pixel, -cy * pixel, 0},
                             {pixel, 0, 0}, {0, pixel, 0}, {0, 0, 1});
  }
  picture.world_from_camera.linear() = axes;
  picture.world_from_camera.translation() =
      middle + axes * Eigen::Vector3d(shift.x(), shift.y(), -back);
  return picture;
}

}  // namespace

ViewingDirection viewing_direction(const Eigen::Vector3d& towards_viewer,
                                   const Eigen::Vector3d& up) {
  const Eigen::Vector3d towards = world_from_upright(up).transpose() * towards_viewer;
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  return {.azimuth_deg = kDegrees * std::atan2(towards.x(), -towards.y()),
          .elevation_deg = kDegrees * std::asin(std::clamp(towards.z(), -1.0, 1.0))};
}

std::vector<ViewingDirection> six_sides() {
  return {{0, 0, 0}, {90, 0, 0}, {180, 0, 0}, {270, 0, 0}, {0, 90, 0}, {0, -90, 0}};
}

std::vector<ViewingDirection> turntable_directions(const ViewingDirection& first, int count) {
  std::vector<ViewingDirection> directions(static_cast<std::size_t>(count), first);
  for (int i = 0; i < count; ++i)
    directions[static_cast<std::size_t>(i)].azimuth_deg += 360.0 * i / count;
  return directions;
}

PictureCamera frame_mesh(const TriangleMesh& mesh, const ViewingDirection& direction,
                         const FramingOptions& options) {
  assert(options.width >= 1 && options.height >= 1);
  const Eigen::Matrix3d axes = camera_axes(direction, options.up);
  const Eigen::Vector3d middle = middle_of(mesh);
  const Reach reach = reach_of(mesh, axes, middle, options);
  const Eigen::Array2d shift = 0.5 * (reach.after - reach.before);
  return camera_at(axes, middle, shift, distance_for(reach, options), reach.front, options);
}

std::vector<PictureCamera> frame_series(const TriangleMesh& mesh,
                                        const std::vector<ViewingDirection>& directions,
                                        const FramingOptions& options) {
  const Eigen::Vector3d middle = middle_of(mesh);
  double distance = 0.0, front = 0.0;
  for (const ViewingDirection& direction : directions) {
    Reach reach = reach_of(mesh, camera_axes(direction, options.up), middle, options);
    reach.after = reach.before = reach.after.max(reach.before);
    distance = std::max(distance, distance_for(reach, options));
    front = std::max(front, reach.front);
  }
  std::vector<PictureCamera> cameras;
  for (const ViewingDirection& direction : directions)
    cameras.push_back(camera_at(camera_axes(direction, options.up), middle, Eigen::Array2d::Zero(),
                                distance, front, options));
  return cameras;
}

PictureCamera frame_view(const RangeView& view, int width, int height) {
  Eigen::AlignedBox2d box;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v)) box.extend(Eigen::Vector2d(u, v));
  if (box.isEmpty()) box = {Eigen::Vector2d::Zero(), Eigen::Vector2d(view.width(), view.height())};
  constexpr double kMargin = 2.0;  // [pixels of the view] Samples reach half a pixel outwards.
  box.extend((box.min().array() - kMargin).matrix().eval());
  box.extend((box.max().array() + kMargin).matrix().eval());
  PictureCamera picture{view.camera, view.world_from_view};
  const double step = std::max(box.sizes().x() / width, box.sizes().y() / height);
  const Eigen::Array2d size = (box.sizes().array() / step).round().max(1.0);
  picture.width = std::min(width, static_cast<int>(size.x()));
  picture.height = std::min(height, static_cast<int>(size.y()));
  const Eigen::Array2d last(picture.width - 1, picture.height - 1);
  picture.step = {step, step};
  picture.first = box.center().array() - 0.5 * picture.step * last;
  if (picture.picture_axes().determinant() < 0.0) {
    picture.step.y() = -step;
    picture.first.y() += step * last.y();
  }
  return picture;
}

}  // namespace relief::rendering
