#include "registration/calibration/model/sensor_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "registration/calibration/model/corrected_camera.h"

namespace relief::registration {

namespace {

// Every so many rows and columns a sample takes part in means over a view. Bounds the time; means
// of thousands of samples serve.
constexpr int kStride = 4;

// Legendre polynomials of degree 0 to 4 with mean square 1 on [-1, 1].
double legendre(int degree, double x) {
  const double s = x * x;
  switch (degree) {
    case 1:
      return std::sqrt(3.0) * x;
    case 2:
      return std::sqrt(5.0) * 0.5 * (3.0 * s - 1.0);
    case 3:
      return std::sqrt(7.0) * 0.5 * (5.0 * s - 3.0) * x;
    case 4:
      return 0.375 * ((35.0 * s - 30.0) * s + 3.0);
    default:
      return 1.0;
  }
}

// 1 on even rows, -1 on odd ones, linear between.
double row_sign(double v) {
  const double row = std::floor(v);
  const double sign = std::fmod(row, 2.0) == 0.0 ? 1.0 : -1.0;
  return sign * (1.0 - 2.0 * (v - row));
}

template <typename Visit>
void for_some_samples(const RangeView& view, const Visit& visit) {
  for (int v = 0; v < view.height(); v += kStride)
    for (int u = (v / kStride) % 2; u < view.width(); u += kStride)
      if (view.has_sample(u, v)) visit(u, v);
}

bool is_pinhole(const Camera& camera) {
  return camera.model() == Camera::Model::kPinhole || camera.model() == Camera::Model::kPinholeGl;
}

bool share_sensor(const Camera& a, const Camera& b) {
  if (a.model() != b.model() || a.width() != b.width() || a.height() != b.height()) return false;
  if (!is_pinhole(a)) return true;
  const PinholeIntrinsics &p = a.intrinsics(), &q = b.intrinsics();
  return p.fx == q.fx && p.fy == q.fy && p.cx == q.cx && p.cy == q.cy;
}

}  // namespace

struct SensorModel::Place {
  const Camera* camera = nullptr;
  Ray ray;
  double length = 1.0;     // Of the ray's direction.
  double range = 0.0;      // [unit], along the ray, as a length.
  Eigen::Vector2d pixel;   // Relative to the samples' extent: -1 to 1.
  double row_sign = 0.0;   // Of interlacing.
  Eigen::Vector3d column;  // What one column moves the sample by.
};

SensorModel::SensorModel(const std::vector<const RangeView*>& views, double spacing)
    : spacing_(spacing) {
  list_terms(views.front()->camera);
  measure_extent(views);
  scale_terms(views);
}

void SensorModel::list_terms(const Camera& camera) {
  const auto add = [this](SensorError error, int i = 0, int j = 0) {
    terms_.push_back({error, i, j});
  };
  add(SensorError::kRangeOffset);
  add(SensorError::kRangeScale);
  add(SensorError::kRangeNonlinearity);
  constexpr std::array kWarps = {SensorError::kQuadraticWarp, SensorError::kQuadraticWarp,
                                 SensorError::kCubicWarp, SensorError::kQuarticWarp};
  for (int degree = 1; degree <= 4; ++degree)
    for (int j = 0; j <= degree; ++j)
      add(kWarps[static_cast<std::size_t>(degree - 1)], degree - j, j);
  from_centre_ = is_pinhole(camera) || camera.model() == Camera::Model::kSpherical;
  if (is_pinhole(camera)) {
    add(SensorError::kFocalLength);
    add(SensorError::kAspectRatio);
    for (int k = 0; k < 2; ++k) add(SensorError::kPrincipalPoint, k);
    for (int k = 0; k < 2; ++k) add(SensorError::kRadialDistortion, k);
    for (int k = 0; k < 2; ++k) add(SensorError::kTangentialDistortion, k);
    add(SensorError::kRayLengths);
  } else if (camera.model() == Camera::Model::kRayTable) {
    add(SensorError::kInterlacing);
  }
}

void SensorModel::measure_extent(const std::vector<const RangeView*>& views) {
  Eigen::Array2d least = Eigen::Array2d::Constant(1e300), most = -least;
  double sum = 0.0, count = 0.0;
  for (const RangeView* view : views) {
    for_some_samples(*view, [&](int u, int v) {
      least = least.min(Eigen::Array2d(u, v));
      most = most.max(Eigen::Array2d(u, v));
      sum += view->range(u, v) * view->camera.ray(u, v).direction.norm();
      count += 1.0;
    });
  }
  if (count == 0.0) return;
  centre_ = 0.5 * (least + most);
  half_size_ = (0.5 * (most - least)).max(1.0);
  reference_range_ = sum / count;
}

void SensorModel::scale_terms(const std::vector<const RangeView*>& views) {
  std::vector<double> squares(terms_.size(), 0.0);
  double count = 0.0;
  for (const RangeView* view : views) {
    for_some_samples(*view, [&](int u, int v) {
      const Place at = place(*view, Eigen::Vector2d(u, v), view->range(u, v));
      for (std::size_t k = 0; k < terms_.size(); ++k)
        squares[k] += field(terms_[k], at).squaredNorm();
      count += 1.0;
    });
  }
  for (std::size_t k = 0; k < terms_.size(); ++k)
    terms_[k].scale = squares[k] > 0.0 ? spacing_ / std::sqrt(squares[k] / count) : 0.0;
}

SensorModel::Place SensorModel::place(const RangeView& view, const Eigen::Vector2d& pixel,
                                      double range) const {
  Place at;
  at.camera = &view.camera;
  at.ray = view.camera.ray_at(pixel.x(), pixel.y());
  at.length = at.ray.direction.norm();
  at.range = range * at.length;
  at.pixel = (pixel - centre_).cwiseQuotient(half_size_);
  at.row_sign = row_sign(pixel.y());
  at.column = column_step(view.camera, pixel, range);
  return at;
}

double SensorModel::range_field(const Term& term, const Place& at) const {
  const double beyond = at.range - reference_range_;
  switch (term.error) {
    case SensorError::kRangeOffset:
      return 1.0;
    case SensorError::kRangeScale:
      return from_centre_ ? at.range : beyond;
    case SensorError::kRangeNonlinearity:
      return beyond * beyond;
    case SensorError::kQuadraticWarp:
    case SensorError::kCubicWarp:
    case SensorError::kQuarticWarp:
      return legendre(term.i, at.pixel.x()) * legendre(term.j, at.pixel.y());
    case SensorError::kRayLengths:
      return at.range / at.length - at.range;
    default:
      return 0.0;
  }
}

Eigen::Vector3d SensorModel::camera_field(const Term& term, const Place& at) const {
  const Eigen::Vector3d& d = at.ray.direction;
  const double t = at.range / at.length, x = d.x(), y = d.y(), r = x * x + y * y;
  switch (term.error) {
    case SensorError::kFocalLength:
      return -t * Eigen::Vector3d(x, y, 0.0);
    case SensorError::kAspectRatio:
      return -t * Eigen::Vector3d(x, -y, 0.0);
    case SensorError::kPrincipalPoint:
      return term.i == 0 ? Eigen::Vector3d(-t / at.camera->intrinsics().fx, 0.0, 0.0)
                         : Eigen::Vector3d(0.0, -t / at.camera->intrinsics().fy, 0.0);
    case SensorError::kRadialDistortion:
      return t * (term.i == 0 ? r : r * r) * Eigen::Vector3d(x, y, 0.0);
    case SensorError::kTangentialDistortion:
      return t * (term.i == 0 ? Eigen::Vector3d(2.0 * x * y, r + 2.0 * y * y, 0.0)
                              : Eigen::Vector3d(r + 2.0 * x * x, 2.0 * x * y, 0.0));
    case SensorError::kInterlacing:
      return 0.5 * at.row_sign * at.column;
    default:
      return Eigen::Vector3d::Zero();
  }
}

Eigen::Vector3d SensorModel::field(const Term& term, const Place& at) const {
  const bool of_range =
      term.error <= SensorError::kQuarticWarp || term.error == SensorError::kRayLengths;
  return term.scale * (of_range
                           ? Eigen::Vector3d(range_field(term, at) / at.length * at.ray.direction)
                           : camera_field(term, at));
}

void SensorModel::project(const RangeView& view, const Eigen::Vector2d& pixel, double range,
                          const Eigen::Vector3d& normal, std::span<double> along_normal) const {
  const Place at = place(view, pixel, range);
  for (std::size_t k = 0; k < terms_.size(); ++k)
    along_normal[k] = normal.dot(field(terms_[k], at));
}

double SensorModel::range_correction(const RangeView& view, const Eigen::Vector2d& pixel,
                                     double range, std::span<const double> coefficients) const {
  const Place at = place(view, pixel, range);
  double sum = 0.0;
  for (std::size_t k = 0; k < terms_.size(); ++k)
    if (coefficients[k] != 0.0)  // Of most terms it is.
      sum += coefficients[k] * terms_[k].scale * range_field(terms_[k], at);
  return sum;
}

RangeView SensorModel::corrected(const RangeView& view,
                                 std::span<const double> coefficients) const {
  RangeView result = view;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const Eigen::Vector2d pixel(u, v);
      const double length = view.camera.ray(u, v).direction.norm();
      result.range(u, v) += range_correction(view, pixel, view.range(u, v), coefficients) / length;
    }
  }
  CameraCorrection camera;
  for (std::size_t k = 0; k < terms_.size(); ++k)
    camera.add(terms_[k].error, terms_[k].i, natural(k, coefficients[k]));
  result.camera = corrected_camera(result, camera);
  return result;
}

Sensors find_sensors(const std::vector<const RangeView*>& views,
                     const std::vector<double>& spacings) {
  Sensors sensors;
  std::vector<std::vector<const RangeView*>> members;
  std::vector<std::vector<double>> spacings_of;
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::size_t s = 0;
    while (s < members.size() && !share_sensor(members[s].front()->camera, views[i]->camera)) ++s;
    if (s == members.size()) {
      members.emplace_back();
      spacings_of.emplace_back();
    }
    sensors.of_view.push_back(s);
    members[s].push_back(views[i]);
    spacings_of[s].push_back(spacings[i]);
  }
  for (std::size_t s = 0; s < members.size(); ++s) {
    std::vector<double>& of = spacings_of[s];
    std::nth_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2), of.end());
    sensors.models.emplace_back(members[s], of[of.size() / 2]);
  }
  return sensors;
}

}  // namespace relief::registration
