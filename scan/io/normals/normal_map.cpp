#include "scan/io/normals/normal_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "scan/base/median.h"
#include "scan/base/srgb.h"
#include "scan/io/files/io_error.h"

namespace relief {

namespace {

const Eigen::Vector3f kNoNormal = Eigen::Vector3f::Constant(static_cast<float>(kNoSample));

constexpr double kPower = 2.2;  // Of most screens, and of programs without the curve of sRGB.

// The value from 0 to 1 before a curve was applied.
double undone(TransferCurve curve, double value) {
  switch (curve) {
    case TransferCurve::kSrgb:
      return linear_from_srgb(value);
    case TransferCurve::kPower:
      return std::pow(value, kPower);
    case TransferCurve::kSrgbLinear:
      return srgb_from_linear(value);
    case TransferCurve::kPowerLinear:
      return std::pow(value, 1.0 / kPower);
    case TransferCurve::kNone:
      break;
  }
  return value;
}

// What the values of an image mean.
struct Decoding {
  NormalEncoding encoding = NormalEncoding::kUnit;
  TransferCurve curve = TransferCurve::kNone;
};

Eigen::Vector3d decode(const Image& image, const Decoding& decoding, int u, int v) {
  Eigen::Vector3d value(image(u, v, 0), image(u, v, 1), image(u, v, 2));
  if (decoding.encoding == NormalEncoding::kUnit) return value;
  value /= image.max_value > 0.0 ? image.max_value : 1.0;
  if (decoding.curve != TransferCurve::kNone)
    for (double& component : value)
      component = undone(decoding.curve, std::clamp(component, 0.0, 1.0));
  return 2.0 * value - Eigen::Vector3d::Ones();
}

// Median distance of the decoded vectors from unit length; 0 without any.
double length_error(const Image& image, const Decoding& decoding, const RangeView& view) {
  constexpr double kEnough = 1 << 16;  // Samples for a median. Bounds the time.
  const int step = std::max(1, static_cast<int>(std::sqrt(view.sample_count() / kEnough)));
  std::vector<double> errors;
  for (int v = 0; v < view.height(); v += step)
    for (int u = 0; u < view.width(); u += step)
      if (view.has_sample(u, v))
        if (const double d = std::abs(decode(image, decoding, u, v).norm() - 1.0); d == d)
          errors.push_back(d);
  return median(errors);
}

// Integer images can hold components only as rgb; of a real image the encoding whose vectors are
// closer to unit length.
NormalEncoding find_encoding(const Image& image, const RangeView& view) {
  if (image.max_value > 0.0) return NormalEncoding::kRgb;
  const double unit = length_error(image, {NormalEncoding::kUnit}, view);
  return unit <= length_error(image, {NormalEncoding::kRgb}, view) ? NormalEncoding::kUnit
                                                                   : NormalEncoding::kRgb;
}

// The curve without which the vectors are far closer to unit length than as they stand, if there is
// one. Those that blurring or compression has shortened have no such curve.
TransferCurve find_curve(const Image& image, NormalEncoding encoding, const RangeView& view) {
  // Times as close. The right curve leaves the rounding of 8 bits: 20 times and more on maps of a
  // statue with any of the curves, 2 at most on maps without one.
  constexpr double kFarCloser = 4.0;
  // What rounding to 8 bits leaves at most: half a level of three components.
  constexpr double kRounding = 0.007;
  TransferCurve best = TransferCurve::kNone;
  if (encoding == NormalEncoding::kUnit) return best;
  const double as_stored = length_error(image, {encoding}, view);
  if (as_stored < kRounding) return best;
  double least = as_stored / kFarCloser;
  for (const auto curve : {TransferCurve::kSrgb, TransferCurve::kPower, TransferCurve::kSrgbLinear,
                           TransferCurve::kPowerLinear}) {
    const double error = length_error(image, {encoding, curve}, view);
    if (!(error < least)) continue;
    least = error;
    best = curve;
  }
  return best;
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

StoredNormals decoded_normals(const Image& image, const Decoding& decoding, const NormalSpec& spec,
                              const RangeView& view) {
  StoredNormals stored;
  stored.components = Grid<Eigen::Vector3f>(view.width(), view.height(), kNoNormal);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      stored.components(u, v) = decode(image, decoding, u, v).cast<float>();
  stored.evidence = evidence_of(spec.file, view, stored.components);
  stored.evidence.kind = NormalFileKind::kImage;
  stored.evidence.encoding = decoding.encoding;
  stored.evidence.curve = decoding.curve;
  stored.evidence.usual = usual_conventions(spec, view);
  stored.evidence.declared = spec.axes && spec.space && spec.encoding;
  stored.evidence.view_from_camera = sensor_axes(view.camera);
  return stored;
}

// The median angle to the depth in the convention that is closest to it [rad]; 0 without patches.
double least_angle(const NormalEvidence& evidence) {
  double least = std::numbers::pi;
  for (const NormalConvention& convention : all_conventions(evidence.kind))
    if (evidence.possible(convention))
      least = std::min(least, agreement(evidence, convention).median);
  return least;
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
  StoredNormals stored = decoded_normals(image, {encoding}, spec, view);
  if (const TransferCurve curve = find_curve(image, encoding, view);
      curve != TransferCurve::kNone) {
    StoredNormals without_curve = decoded_normals(image, {encoding, curve}, spec, view);
    if (least_angle(without_curve.evidence) <= least_angle(stored.evidence))
      stored = std::move(without_curve);
  }
  stored.evidence.placement = find_placement(stored.evidence, stored.components);
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
