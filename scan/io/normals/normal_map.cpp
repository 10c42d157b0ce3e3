#include "scan/io/normals/normal_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "scan/base/median.h"
#include "scan/io/files/io_error.h"

namespace relief {

namespace {

const Eigen::Vector3f kNoNormal = Eigen::Vector3f::Constant(static_cast<float>(kNoSample));

Eigen::Vector3d decode(const Image& image, NormalEncoding encoding, int u, int v) {
  const Eigen::Vector3d value(image(u, v, 0), image(u, v, 1), image(u, v, 2));
  if (encoding == NormalEncoding::kUnit) return value;
  const double max = image.max_value > 0.0 ? image.max_value : 1.0;
  return value * (2.0 / max) - Eigen::Vector3d::Ones();
}

bool is_direction(const Eigen::Vector3d& vector) {
  const double length = vector.norm();
  return length >= 0.5 && length <= 1.5;
}

// Median distance of the decoded vectors from unit length; 0 without any.
double length_error(const Image& image, NormalEncoding encoding, const RangeView& view) {
  std::vector<double> errors;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v))
        if (const double d = std::abs(decode(image, encoding, u, v).norm() - 1.0); d == d)
          errors.push_back(d);
  return median(errors);
}

// Integer images can hold components only as rgb; of a real image the encoding whose vectors are
// closer to unit length.
NormalEncoding find_encoding(const Image& image, const RangeView& view) {
  if (image.max_value > 0.0) return NormalEncoding::kRgb;
  const double unit = length_error(image, NormalEncoding::kUnit, view);
  return unit <= length_error(image, NormalEncoding::kRgb, view) ? NormalEncoding::kUnit
                                                                 : NormalEncoding::kRgb;
}

// The usual conventions that agree with what is stated, the likelier first.
std::vector<NormalConvention> usual_conventions(const NormalSpec& spec, const RangeView& view) {
  std::vector<NormalConvention> usual;
  for (const auto space : {NormalSpace::kCamera, NormalSpace::kWorld}) {
    if (spec.space ? space != *spec.space
                   : space == NormalSpace::kWorld && view.pose == PoseKind::kAbsent)
      continue;
    for (const auto axes : {NormalAxes::kOpencv, NormalAxes::kOpengl})
      if (!spec.axes || axes == *spec.axes) usual.push_back(named_convention(axes, space));
  }
  return usual;
}

NormalEvidence evidence_of(const std::filesystem::path& file, const RangeView& view,
                           const Grid<Eigen::Vector3f>& components) {
  NormalEvidence evidence;
  evidence.view = view.name;
  evidence.file = file;
  evidence.view_from_world = view.world_from_view.linear().transpose();
  evidence.has_pose = view.pose != PoseKind::kAbsent;
  Grid<Eigen::Vector3f> directions = components;
  for (auto& vector : directions)
    if (!is_direction(vector.cast<double>())) vector = kNoNormal;
  evidence.patches = find_patches(view, directions);
  return evidence;
}

}  // namespace

Eigen::Matrix3d sensor_axes(const Camera& camera) {
  if (camera.model() == Camera::Model::kPinhole) return Eigen::Matrix3d::Identity();
  if (camera.model() == Camera::Model::kPinholeGl) return Eigen::Vector3d(1, 1, -1).asDiagonal();
  // Neighbouring rays at the depth of the frame's origin, or as near to it as they have a range.
  const int u = std::max(0, camera.width() / 2 - 1), v = std::max(0, camera.height() / 2 - 1);
  const Ray centre = camera.ray_at(u, v);
  const Eigen::Vector3d forward = centre.direction.normalized();
  const double t = std::max(1.0, centre.range_of(Eigen::Vector3d::Zero()));
  const auto across = [&](const Ray& ray) -> Eigen::Vector3d {
    const Eigen::Vector3d step = ray.at(t) - centre.at(t);
    return (step - step.dot(forward) * forward).normalized();
  };
  const Eigen::Vector3d right = across(camera.ray_at(u + 1, v));
  const Eigen::Vector3d down = across(camera.ray_at(u, v + 1));
  Eigen::Matrix3d axes;
  axes << right, forward.cross(right) * (forward.cross(right).dot(down) < 0.0 ? -1.0 : 1.0),
      forward;
  return axes;
}

Result<StoredNormals> stored_in_image(const Image& image, const NormalSpec& spec,
                                      const RangeView& view) {
  if (image.channels != 3) return bad_input(spec.file, "a normal map has three channels, not one");
  if (spec.space == NormalSpace::kWorld && view.pose == PoseKind::kAbsent)
    return bad_input(spec.file, "its normals are in world space, but view " + view.name +
                                    " has no world_from_view");
  const NormalEncoding encoding = spec.encoding ? *spec.encoding : find_encoding(image, view);
  StoredNormals stored;
  stored.components = Grid<Eigen::Vector3f>(view.width(), view.height(), kNoNormal);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      stored.components(u, v) = decode(image, encoding, u, v).cast<float>();
  stored.evidence = evidence_of(spec.file, view, stored.components);
  stored.evidence.kind = NormalFileKind::kImage;
  stored.evidence.encoding = encoding;
  stored.evidence.usual = usual_conventions(spec, view);
  stored.evidence.declared = spec.axes && spec.space && spec.encoding;
  stored.evidence.view_from_camera = sensor_axes(view.camera);
  return stored;
}

StoredNormals stored_in_grid(Grid<Eigen::Vector3f> normals, const std::filesystem::path& file,
                             const RangeView& view) {
  StoredNormals stored;
  stored.components = std::move(normals);
  stored.evidence = evidence_of(file, view, stored.components);
  stored.evidence.kind = NormalFileKind::kGrid;
  stored.evidence.usual = {NormalConvention{}};
  stored.evidence.declared = true;
  return stored;
}

std::vector<std::string> apply_convention(const StoredNormals& stored,
                                          const ChosenConvention& chosen, RangeView& view) {
  view.normals = {};
  if (!chosen.usable) return {};
  const Eigen::Matrix3d to_view = stored.evidence.view_from_stored(chosen.convention);
  view.normals = Grid<Eigen::Vector3f>(view.width(), view.height(), kNoNormal);
  std::size_t averted = 0, undirected = 0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      const std::size_t sample = view.has_sample(u, v) ? 1 : 0;
      const Eigen::Vector3d vector = to_view * stored.components(u, v).cast<double>();
      if (!is_direction(vector))
        undirected += sample;
      else if (!(vector.dot(view.camera.ray(u, v).direction) < 0.0))
        averted += sample;
      else
        view.normals(u, v) = vector.normalized().cast<float>();
    }
  }
  std::vector<std::string> notes;
  const std::string file = stored.evidence.file.string(),
                    of = " of " + std::to_string(view.sample_count()) + " samples";
  if (undirected > 0)
    notes.push_back(file + ": " + std::to_string(undirected) + of + " have no normal");
  if (averted > 0)
    notes.push_back(file + ": the normals of " + std::to_string(averted) + of +
                    " face away from the sensor and are not used");
  return notes;
}

}  // namespace relief
