#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <vtkDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkStringArray.h>

#include "interop/vtk_fields_private.h"

namespace relief::interop {

namespace {

constexpr std::array<Camera::Model, 5> kModels{Camera::Model::kPinhole, Camera::Model::kPinholeGl,
                                               Camera::Model::kOrthographic,
                                               Camera::Model::kSpherical, Camera::Model::kRayTable};

constexpr std::array<std::string_view, 3> kPoseNames{"absent", "guess", "known"};

Error bad_field(const std::string& what) { return {ErrorKind::kBadInput, what}; }

void add_text(vtkFieldData& data, const char* name, const std::string& text) {
  vtkNew<vtkStringArray> array;
  array->SetName(name);
  array->InsertNextValue(text);
  data.AddArray(array);
}

std::string text_of(vtkFieldData& data, const char* name) {
  auto* array = vtkStringArray::SafeDownCast(data.GetAbstractArray(name));
  return array && array->GetNumberOfValues() > 0 ? std::string(array->GetValue(0)) : std::string();
}

void append(std::vector<double>& values, const Eigen::Ref<const Eigen::VectorXd>& vector) {
  for (const double value : vector) values.push_back(value);
}

std::vector<double> camera_numbers(const Camera& camera) {
  std::vector<double> numbers;
  if (camera.model() == Camera::Model::kOrthographic) {
    const Ray corner = camera.ray_at(0, 0);
    append(numbers, corner.origin);
    append(numbers, camera.ray_at(1, 0).origin - corner.origin);
    append(numbers, camera.ray_at(0, 1).origin - corner.origin);
    append(numbers, corner.direction);
  } else if (const SphericalProjection* angles = camera.spherical_projection()) {
    numbers = angles->azimuth;
    numbers.insert(numbers.end(), angles->elevation.begin(), angles->elevation.end());
  } else if (camera.model() != Camera::Model::kRayTable) {
    const PinholeIntrinsics& k = camera.intrinsics();
    numbers = {k.fx, k.fy, k.cx, k.cy};
  } else if (camera.projection()) {
    append(numbers, camera.projection()->u_numerator);
    append(numbers, camera.projection()->u_denominator);
    append(numbers, camera.projection()->v_numerator);
    append(numbers, camera.projection()->v_denominator);
  }
  return numbers;
}

void write_rays(const Camera& camera, vtkFieldData& fields) {
  std::vector<double> origins, directions;
  for (int v = 0; v < camera.height(); ++v) {
    for (int u = 0; u < camera.width(); ++u) {
      append(origins, camera.ray(u, v).origin);
      append(directions, camera.ray(u, v).direction);
    }
  }
  add_doubles(fields, "ray_origin", 3, origins);
  add_doubles(fields, "ray_direction", 3, directions);
}

// The tuples of an array that must be there, one behind the other, all finite.
Result<std::vector<double>> read_doubles(vtkFieldData& fields, const char* name, int components,
                                         std::size_t tuples) {
  const auto array = find_array(fields, name, components, tuples);
  if (!array) return array.error();
  if (!*array) return bad_field(std::string("the field data has no array '") + name + "'");
  std::vector<double> values;
  for (vtkIdType i = 0; i < (*array)->GetNumberOfTuples(); ++i)
    for (int c = 0; c < components; ++c) values.push_back((*array)->GetComponent(i, c));
  for (const double value : values)
    if (!std::isfinite(value))
      return bad_field(std::string("the array '") + name + "' holds what is no number");
  return values;
}

Eigen::Vector3d vector_at(const std::vector<double>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

Result<Camera> read_pinhole(vtkFieldData& fields, bool gl, int width, int height) {
  const auto k = read_doubles(fields, "camera", 4, 1);
  if (!k) return k.error();
  const PinholeIntrinsics intrinsics{(*k)[0], (*k)[1], (*k)[2], (*k)[3]};
  if (intrinsics.fx == 0.0 || intrinsics.fy == 0.0)
    return bad_field("the array 'camera' has a focal length of 0");
  return gl ? Camera::pinhole_gl(width, height, intrinsics)
            : Camera::pinhole(width, height, intrinsics);
}

Result<Camera> read_orthographic(vtkFieldData& fields, int width, int height) {
  const auto numbers = read_doubles(fields, "camera", 12, 1);
  if (!numbers) return numbers.error();
  Eigen::Matrix3d axes;
  axes << vector_at(*numbers, 1), vector_at(*numbers, 2), vector_at(*numbers, 3);
  if (axes.determinant() == 0.0)
    return bad_field("the array 'camera' has steps and a direction in one plane");
  return Camera::orthographic(width, height, vector_at(*numbers, 0), axes.col(0), axes.col(1),
                              axes.col(2));
}

// The azimuths of the columns and the elevations of the rows [rad].
Result<SphericalProjection> read_angles(vtkFieldData& fields, int width, int height) {
  const auto numbers = read_doubles(fields, "camera", width + height, 1);
  if (!numbers) return numbers.error();
  SphericalProjection angles;
  angles.azimuth.assign(numbers->begin(), numbers->begin() + width);
  angles.elevation.assign(numbers->begin() + width, numbers->end());
  if (!angles.valid())
    return bad_field("the array 'camera' has angles that do not grow or fall strictly in a turn");
  return angles;
}

Result<Camera> read_ray_table(vtkFieldData& fields, int width, int height) {
  Grid<Ray> rays(width, height);
  const auto origins = read_doubles(fields, "ray_origin", 3, rays.size());
  if (!origins) return origins.error();
  const auto directions = read_doubles(fields, "ray_direction", 3, rays.size());
  if (!directions) return directions.error();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    rays[i] = {vector_at(*origins, i), vector_at(*directions, i)};
    if (rays[i].direction.isZero(0.0))
      return bad_field("the array 'ray_direction' has a direction of no length");
  }
  if (!fields.GetArray("camera")) return Camera::ray_table(std::move(rays), std::nullopt);
  if (fields.GetArray("camera")->GetNumberOfComponents() != 16) {
    auto angles = read_angles(fields, width, height);
    if (!angles) return angles.error();
    return Camera::ray_table(std::move(rays), std::move(*angles));
  }
  const auto numbers = read_doubles(fields, "camera", 16, 1);
  if (!numbers) return numbers.error();
  const auto row = [&](std::size_t i) {
    return Eigen::Vector4d(Eigen::Vector4d::Map(numbers->data() + 4 * i));
  };
  return Camera::ray_table(std::move(rays), RationalProjection{row(0), row(1), row(2), row(3)});
}

Result<Camera> read_camera(vtkFieldData& fields, Camera::Model model, int width, int height) {
  if (model == Camera::Model::kOrthographic) return read_orthographic(fields, width, height);
  if (model == Camera::Model::kRayTable) return read_ray_table(fields, width, height);
  if (model == Camera::Model::kSpherical) {
    auto angles = read_angles(fields, width, height);
    if (!angles) return angles.error();
    return Camera::spherical(std::move(*angles));
  }
  return read_pinhole(fields, model == Camera::Model::kPinholeGl, width, height);
}

}  // namespace

void add_doubles(vtkFieldData& data, const char* name, int components,
                 const std::vector<double>& values) {
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(static_cast<vtkIdType>(values.size()) / components);
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  data.AddArray(array);
}

Result<vtkDataArray*> find_array(vtkFieldData& data, const char* name, int components,
                                 std::size_t tuples) {
  vtkDataArray* array = data.GetArray(name);
  if (!array || (array->GetNumberOfComponents() == components &&
                 static_cast<std::size_t>(array->GetNumberOfTuples()) == tuples))
    return array;
  return bad_field(std::string("the array '") + name + "' has " +
                   std::to_string(array->GetNumberOfTuples()) + " x " +
                   std::to_string(array->GetNumberOfComponents()) + " numbers, not " +
                   std::to_string(tuples) + " x " + std::to_string(components));
}

void write_view_fields(const RangeView& view, vtkDataSet& data) {
  vtkFieldData& fields = *data.GetFieldData();
  add_text(fields, "name", view.name);
  add_text(fields, "pose", std::string(kPoseNames[static_cast<std::size_t>(view.pose)]));
  if (view.samples == SampleOrigin::kRefined) add_text(fields, "samples", "refined");
  add_text(fields, "camera_model", std::string(to_string(view.camera.model())));
  std::vector<double> pose;
  for (Eigen::Index row = 0; row < 4; ++row)
    append(pose, view.world_from_view.matrix().row(row).transpose());
  add_doubles(fields, "world_from_view", 16, pose);
  const std::vector<double> camera = camera_numbers(view.camera);
  if (!camera.empty()) add_doubles(fields, "camera", static_cast<int>(camera.size()), camera);
  if (view.camera.model() == Camera::Model::kRayTable) write_rays(view.camera, fields);
}

Result<void> read_pose_fields(vtkDataSet& data, RangeView& view) {
  vtkFieldData& fields = *data.GetFieldData();
  view.name = text_of(fields, "name");
  if (text_of(fields, "samples") == "refined") view.samples = SampleOrigin::kRefined;
  if (!fields.GetArray("world_from_view")) return {};
  const auto numbers = read_doubles(fields, "world_from_view", 16, 1);
  if (!numbers) return numbers.error();
  const Eigen::Matrix4d matrix = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>::Map(numbers->data());
  const auto motion = rigid_motion_from_matrix(matrix, "the array 'world_from_view'");
  if (!motion) return motion.error();
  view.world_from_view = *motion;
  view.pose = PoseKind::kGuess;
  const std::string kind = text_of(fields, "pose");
  for (std::size_t k = 0; k < kPoseNames.size(); ++k)
    if (kind == kPoseNames[k]) view.pose = static_cast<PoseKind>(k);
  return {};
}

Result<std::optional<Camera>> read_camera_fields(vtkDataSet& data, int width, int height) {
  vtkFieldData& fields = *data.GetFieldData();
  const std::string name = text_of(fields, "camera_model");
  if (name.empty()) return std::optional<Camera>();
  for (const Camera::Model model : kModels) {
    if (name != to_string(model)) continue;
    auto camera = read_camera(fields, model, width, height);
    if (!camera) return camera.error();
    return std::optional(std::move(*camera));
  }
  return bad_field("unknown camera_model '" + name +
                   "'; use pinhole, pinhole_gl, orthographic or ray table");
}

}  // namespace relief::interop
