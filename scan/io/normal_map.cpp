#include "scan/io/normal_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <Eigen/Geometry>

#include "scan/grid_normals.h"
#include "scan/io/io_error.h"
#include "scan/median.h"

namespace relief {

namespace {

constexpr double kAgreesDeg = 35.0;       // median angle up to which a convention fits the depth
constexpr double kContradictsDeg = 60.0;  // and from which it does not
constexpr int kReferenceRadius = 3;
const Eigen::Vector3f kNoNormal = Eigen::Vector3f::Constant(static_cast<float>(kNoSample));

struct Convention {
  NormalAxes axes = NormalAxes::kOpencv;
  NormalSpace space = NormalSpace::kCamera;
};

std::string name_of(NormalEncoding encoding, const Convention& convention) {
  return std::string("encoding ") + (encoding == NormalEncoding::kRgb ? "rgb" : "unit") +
         ", axes " + (convention.axes == NormalAxes::kOpencv ? "opencv" : "opengl") + ", space " +
         (convention.space == NormalSpace::kCamera ? "camera" : "world");
}

// Takes decoded components into the view frame.
Eigen::Matrix3d view_from_image(const Convention& convention, const RangeView& view) {
  const Eigen::Matrix3d axes = convention.axes == NormalAxes::kOpengl
                                   ? Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix()
                                   : Eigen::Matrix3d::Identity();
  if (convention.space == NormalSpace::kWorld)
    return view.world_from_view.linear().transpose() * axes;
  return sensor_axes(view.camera) * axes;
}

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

// Integer images can hold components only as rgb; of a real image the encoding whose vectors are
// closer to unit length.
NormalEncoding find_encoding(const Image& image, const RangeView& view) {
  if (image.max_value > 0.0) return NormalEncoding::kRgb;
  const auto deviation = [&](NormalEncoding encoding) {
    std::vector<double> deviations;
    for (int v = 0; v < view.height(); ++v)
      for (int u = 0; u < view.width(); ++u)
        if (view.has_sample(u, v))
          if (const double d = std::abs(decode(image, encoding, u, v).norm() - 1.0); d == d)
            deviations.push_back(d);
    return deviations.empty() ? 0.0 : median(deviations);
  };
  return deviation(NormalEncoding::kUnit) <= deviation(NormalEncoding::kRgb) ? NormalEncoding::kUnit
                                                                             : NormalEncoding::kRgb;
}

// Median angle [deg] between the decoded normals and those of the depth; 180 without any.
double median_angle_deg(const Image& image, NormalEncoding encoding, const Eigen::Matrix3d& to_view,
                        const Grid<Eigen::Vector3f>& reference) {
  std::vector<double> cosines;
  for (int v = 0; v < reference.height(); ++v) {
    for (int u = 0; u < reference.width(); ++u) {
      if (!reference(u, v).allFinite()) continue;
      const Eigen::Vector3d decoded = decode(image, encoding, u, v);
      if (is_direction(decoded))
        cosines.push_back((to_view * decoded).normalized().dot(reference(u, v).cast<double>()));
    }
  }
  if (cosines.empty()) return 180.0;
  return std::acos(std::clamp(median(cosines), -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

// Some thousand normals settle a convention.
int stride_of(const RangeView& view) {
  const double per_normal = static_cast<double>(view.sample_count()) / 4000.0;
  return std::max(1, static_cast<int>(std::sqrt(per_normal)));
}

struct Scored {
  Convention convention;
  double angle_deg = 180.0;
};

class ConventionSearch {
 public:
  ConventionSearch(const Image& image, NormalEncoding encoding, const RangeView& view)
      : image_(image), encoding_(encoding), view_(view) {
    reference_ =
        estimate_normals(view, connect_samples(view),
                         {.radius = kReferenceRadius, .stride = stride_of(view), .threads = 1});
  }

  // The best convention among those that agree with what is declared.
  Scored best(std::optional<NormalAxes> axes, std::optional<NormalSpace> space) const {
    Scored best;
    best.angle_deg = 1000.0;
    for (const auto s : {NormalSpace::kCamera, NormalSpace::kWorld}) {
      if (space ? s != *space : s == NormalSpace::kWorld && view_.pose == PoseKind::kAbsent)
        continue;
      for (const auto a : {NormalAxes::kOpencv, NormalAxes::kOpengl}) {
        if (axes && a != *axes) continue;
        const Convention convention{a, s};
        const double angle =
            median_angle_deg(image_, encoding_, view_from_image(convention, view_), reference_);
        if (angle < best.angle_deg) best = {convention, angle};
      }
    }
    return best;
  }

 private:
  const Image& image_;
  NormalEncoding encoding_;
  const RangeView& view_;
  Grid<Eigen::Vector3f> reference_;
};

std::string degrees(double angle) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f deg", angle);
  return text;
}

// Unit normals of all samples whose vector is a direction and faces the sensor; the others are
// counted in the notes.
NormalMap keep_facing(Grid<Eigen::Vector3f> normals, const RangeView& view,
                      const std::string& file) {
  std::size_t averted = 0, undirected = 0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      Eigen::Vector3f& normal = normals(u, v);
      const Eigen::Vector3d vector = normal.cast<double>();
      normal = kNoNormal;
      if (!view.has_sample(u, v)) continue;
      if (!is_direction(vector))
        ++undirected;
      else if (!(vector.dot(view.camera.ray(u, v).direction) < 0.0))
        ++averted;
      else
        normal = vector.normalized().cast<float>();
    }
  }
  NormalMap map{std::move(normals), {}};
  const std::string of = " of " + std::to_string(view.sample_count()) + " samples";
  if (undirected > 0)
    map.notes.push_back(file + ": " + std::to_string(undirected) + of + " have no normal");
  if (averted > 0)
    map.notes.push_back(file + ": the normals of " + std::to_string(averted) + of +
                        " face away from the sensor and are not used");
  return map;
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

Result<NormalMap> decode_normals(const Image& image, const NormalSpec& spec,
                                 const RangeView& view) {
  const std::string file = spec.file.string();
  if (image.channels != 3) return bad_input(spec.file, "a normal map has three channels, not one");
  if (spec.space == NormalSpace::kWorld && view.pose == PoseKind::kAbsent)
    return bad_input(spec.file, "its normals are in world space, but view " + view.name +
                                    " has no world_from_view");
  const NormalEncoding encoding = spec.encoding ? *spec.encoding : find_encoding(image, view);
  const ConventionSearch search(image, encoding, view);
  const Scored chosen = search.best(spec.axes, spec.space);
  std::vector<std::string> notes;
  if (!spec.axes || !spec.space || !spec.encoding) {
    if (chosen.angle_deg > kAgreesDeg)
      return bad_input(spec.file, "no convention of normals fits the depth of view " + view.name +
                                      ": the best, " + name_of(encoding, chosen.convention) +
                                      ", is off by " + degrees(chosen.angle_deg) +
                                      " (median); check the files, then state encoding, axes and "
                                      "space");
    notes.push_back("view " + view.name + ": normals found to be " +
                    name_of(encoding, chosen.convention) + " (median angle to the depth " +
                    degrees(chosen.angle_deg) + ")");
  } else if (chosen.angle_deg > kContradictsDeg) {
    const Scored other = search.best(std::nullopt, std::nullopt);
    if (other.angle_deg < kAgreesDeg)
      notes.push_back("warning: view " + view.name + ": the normals contradict the depth (median " +
                      degrees(chosen.angle_deg) + ") as declared, but agree (" +
                      degrees(other.angle_deg) + ") as " + name_of(encoding, other.convention));
  }

  const Eigen::Matrix3d to_view = view_from_image(chosen.convention, view);
  Grid<Eigen::Vector3f> normals(view.width(), view.height(), kNoNormal);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      normals(u, v) = (to_view * decode(image, encoding, u, v)).cast<float>();
  NormalMap map = keep_facing(std::move(normals), view, file);
  map.notes.insert(map.notes.begin(), notes.begin(), notes.end());
  return map;
}

NormalMap clean_normals(Grid<Eigen::Vector3f> normals, const RangeView& view,
                        const std::string& file) {
  return keep_facing(std::move(normals), view, file);
}

}  // namespace relief
