#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "scan/io/project/json/camera_json_private.h"

namespace relief {

namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson pinhole_json(Camera::Model model, int width, int height, const PinholeIntrinsics& k) {
  return {{"model", to_string(model)},
          {"width", width},
          {"height", height},
          {"fx", k.fx},
          {"fy", k.fy},
          {"cx", k.cx},
          {"cy", k.cy}};
}

OrderedJson orthographic_json(const Camera& camera, double back) {
  const Ray corner = camera.ray_at(0, 0);
  return {{"model", "orthographic"},
          {"width", camera.width()},
          {"height", camera.height()},
          {"origin", json_of(corner.at(-back))},
          {"step_u", json_of(camera.ray_at(1, 0).origin - corner.origin)},
          {"step_v", json_of(camera.ray_at(0, 1).origin - corner.origin)},
          {"view_direction", json_of(corner.direction)}};
}

// Even angles as the first and the step, others one by one [deg].
void set_angles(OrderedJson& camera, const std::string& key, const std::vector<double>& angles) {
  // [rad] A thousand roundings of an angle of 2 pi; moves a point a kilometre off by a nanometre.
  constexpr double kDegrees = 180.0 / std::numbers::pi, kEven = 1e-12;
  const double step = (angles.back() - angles.front()) / static_cast<double>(angles.size() - 1);
  bool even = true;
  for (std::size_t i = 0; i < angles.size(); ++i)
    even &= std::abs(angles.front() + static_cast<double>(i) * step - angles[i]) <= kEven;
  if (even) {
    camera[key] = angles.front() * kDegrees;
    camera[key + "_step"] = step * kDegrees;
    return;
  }
  camera[key] = OrderedJson::array();
  for (const double angle : angles) camera[key].push_back(angle * kDegrees);
}

OrderedJson spherical_json(const SphericalProjection& projection) {
  OrderedJson camera = {{"model", "spherical"},
                        {"width", projection.azimuth.size()},
                        {"height", projection.elevation.size()}};
  set_angles(camera, "azimuth", projection.azimuth);
  set_angles(camera, "elevation", projection.elevation);
  return camera;
}

OrderedJson rational_json(const RationalProjection& projection, const Eigen::Vector3d& towards) {
  return {{"model", "rational"},
          {"u_numerator", json_of(projection.u_numerator)},
          {"u_denominator", json_of(projection.u_denominator)},
          {"v_numerator", json_of(projection.v_numerator)},
          {"v_denominator", json_of(projection.v_denominator)},
          {"view_direction", json_of(towards)}};
}

// What a reader needs to give a table of rays back to its points.
OrderedJson table_json(const Camera& camera) {
  if (camera.spherical_projection()) return spherical_json(*camera.spherical_projection());
  const Eigen::Vector3d first = camera.ray(0, 0).direction.normalized();
  bool parallel = true;
  for (int v = 0; v < camera.height() && parallel; ++v)
    for (int u = 0; u < camera.width() && parallel; ++u)
      parallel = camera.ray(u, v).direction.normalized().dot(first) > 1.0 - 1e-14;
  if (parallel) return {{"model", "orthographic"}, {"view_direction", json_of(first)}};
  if (!camera.projection()) return nullptr;
  return rational_json(*camera.projection(),
                       camera.ray(camera.width() / 2, camera.height() / 2).direction.normalized());
}

OrderedJson orthographic_json(const CameraSpec& spec) {
  OrderedJson camera = {{"model", "orthographic"}};
  if (spec.origin) camera["origin"] = json_of(*spec.origin);
  if (spec.step_u) camera["step_u"] = json_of(*spec.step_u);
  if (spec.step_v) camera["step_v"] = json_of(*spec.step_v);
  if (spec.view_direction) camera["view_direction"] = json_of(*spec.view_direction);
  return camera;
}

OrderedJson pinhole_json(const CameraSpec& spec) {
  const PinholeIntrinsics& k = spec.intrinsics;
  const bool gl = spec.model == CameraSpec::Model::kPinholeGl;
  OrderedJson camera = {{"model", gl ? "pinhole_gl" : "pinhole"}};
  if (spec.width) camera["width"] = *spec.width;
  if (spec.height) camera["height"] = *spec.height;
  camera.update(OrderedJson{{"fx", k.fx}, {"fy", k.fy}, {"cx", k.cx}, {"cy", k.cy}});
  return camera;
}

}  // namespace

OrderedJson json_of(const Eigen::Ref<const Eigen::VectorXd>& vector) {
  OrderedJson values = OrderedJson::array();
  for (const double value : vector) values.push_back(value);
  return values;
}

OrderedJson json_of(const RigidMotion& motion) {
  OrderedJson rows = OrderedJson::array();
  for (Eigen::Index i = 0; i < 4; ++i)
    rows.push_back(json_of(Eigen::Vector4d(motion.matrix().row(i).transpose())));
  return rows;
}

double step_back(const RangeView& view) {
  if (view.camera.model() != Camera::Model::kOrthographic) return 0.0;
  double nearest = std::numeric_limits<double>::infinity(), farthest = -nearest;
  for (const double t : view.range) {
    if (t != t) continue;
    nearest = std::min(nearest, t);
    farthest = std::max(farthest, t);
  }
  if (!(nearest <= 0.0)) return 0.0;
  return -nearest + std::max(farthest - nearest, sample_spacing(view));
}

OrderedJson camera_json(const RangeView& view) {
  switch (view.camera.model()) {
    case Camera::Model::kSpherical:
    case Camera::Model::kRayTable:
      return table_json(view.camera);
    case Camera::Model::kOrthographic:
      return orthographic_json(view.camera, step_back(view));
    default:
      return pinhole_json(view.camera.model(), view.width(), view.height(),
                          view.camera.intrinsics());
  }
}

OrderedJson camera_json(const CameraSpec& camera) {
  switch (camera.model) {
    case CameraSpec::Model::kOrthographic:
      return orthographic_json(camera);
    case CameraSpec::Model::kRational:
      return rational_json(camera.projection, *camera.view_direction);
    case CameraSpec::Model::kSpherical:
      return spherical_json(camera.angles);
    default:
      return pinhole_json(camera);
  }
}

}  // namespace relief
