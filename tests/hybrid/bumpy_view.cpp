#include "tests/hybrid/bumpy_view.h"

#include <array>
#include <cmath>
#include <random>

#include <Eigen/Geometry>

#include "relief/scan/discontinuities.h"
#include "scan/grid/grid_normals.h"

namespace relief::testing {

namespace {

constexpr double kRadius = 400.0;
const Eigen::Vector3d kCentre(0, 0, 1000);

struct Wave {
  double amplitude, x, y, phase;
};
constexpr std::array<Wave, 5> kWaves{{{1.6, 0.06, 0.066, 0.3},
                                      {0.9, -0.16, 0.1, 1.0},
                                      {0.4, 0.31, 0.22, 2.0},
                                      {0.25, -0.2, 0.45, 0.5},
                                      {0.12, 0.62, -0.3, 4.0}}};

// Height of the relief and its gradient.
double relief_at(double x, double y, Eigen::Vector2d* gradient) {
  double height = 0.0;
  gradient->setZero();
  for (const Wave& w : kWaves) {
    const double phase = w.x * x + w.y * y + w.phase;
    height += w.amplitude * std::sin(phase);
    *gradient += w.amplitude * std::cos(phase) * Eigen::Vector2d(w.x, w.y);
  }
  return height;
}

// Zero on the surface, negative inside.
double value(const Eigen::Vector3d& p, Eigen::Vector3d* gradient) {
  Eigen::Vector2d slope;
  const double height = relief_at(p.x(), p.y(), &slope);
  const Eigen::Vector3d from_centre = p - kCentre;
  *gradient = from_centre.normalized() - Eigen::Vector3d(slope.x(), slope.y(), 0.0);
  return from_centre.norm() - kRadius - height;
}

double angle(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3d x = a.cast<double>(), y = b.cast<double>();
  return std::atan2(x.cross(y).norm(), x.dot(y));
}

Grid<double> smoothed_noise(int width, int height, double sigma, int size, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> gaussian(0.0, sigma);
  Grid<double> white(width + size, height + size, 0.0), smooth(width, height, 0.0);
  for (double& value : white) value = gaussian(generator);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      for (int k = 0; k < size * size; ++k)
        smooth(u, v) += white(u + k % size, v + k / size) / (size * size);
  return smooth;
}

}  // namespace

Surface bumpy_surface() {
  return [](const Ray& ray) -> std::optional<SurfaceHit> {
    const auto start = sphere(kCentre, kRadius)(ray);
    if (!start) return std::nullopt;
    double t = start->t;
    Eigen::Vector3d gradient;
    for (int step = 0; step < 50; ++step)
      t -= value(ray.at(t), &gradient) / gradient.dot(ray.direction);
    value(ray.at(t), &gradient);
    return SurfaceHit{t, gradient.normalized()};
  };
}

Camera bumpy_camera(int width, int height) {
  return Camera::pinhole(width, height,
                         {600.0, 600.0, 0.5 * (width - 1) + 3.0, 0.5 * (height - 1) - 2.0});
}

void add_normal_bias(RangeView& view, double rms_rad) {
  const double pi = 3.141592653589793;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_normal(u, v)) continue;
      const double x = 2.0 * pi * u / view.width(), y = 2.0 * pi * v / view.height();
      const double scale = std::sqrt(2.0) * rms_rad;
      const Eigen::Vector3d turn(scale * std::sin(x + 0.7 * y + 0.4),
                                 scale * std::cos(1.2 * y - 0.5 * x), 0.0);
      const Eigen::AngleAxisd rotation(turn.norm(), turn.normalized());
      view.normals(u, v) = (rotation * view.normals(u, v).cast<double>()).cast<float>();
    }
  }
}

void add_smoothed_range_noise(RangeView& view, double sigma, int size, std::uint32_t seed) {
  const auto noise = smoothed_noise(view.width(), view.height(), sigma, size, seed);
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      view.range(u, v) += noise(u, v) / view.camera.ray(u, v).direction.norm();
}

void add_smoothed_normal_noise(RangeView& view, double sigma_rad, int size, std::uint32_t seed) {
  const auto about_a = smoothed_noise(view.width(), view.height(), sigma_rad, size, seed);
  const auto about_b = smoothed_noise(view.width(), view.height(), sigma_rad, size, seed + 1);
  for (std::size_t i = 0; i < view.normals.size(); ++i) {
    if (!view.normals[i].allFinite()) continue;
    const Eigen::Vector3d normal = view.normals[i].cast<double>();
    const Eigen::Vector3d a = normal.cross(Eigen::Vector3d::UnitX()).normalized();
    const Eigen::Vector3d b = normal.cross(a);
    view.normals[i] = (normal + about_a[i] * a + about_b[i] * b).normalized().cast<float>();
  }
}

void add_normal_outliers(RangeView& view, double fraction, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0), slope(-2.0, 2.0);
  for (auto& normal : view.normals) {
    const bool wild = uniform(generator) < fraction;
    const double x = slope(generator), y = slope(generator);
    if (wild && normal.allFinite()) normal = Eigen::Vector3d(x, y, -1.0).normalized().cast<float>();
  }
}

ViewErrors errors_of(const RangeView& view, const RangeView& truth) {
  ViewErrors errors;
  const Grid<Eigen::Vector3f> surface = finite_difference_normals(view, connect_samples(truth));
  std::size_t samples = 0, surface_count = 0, normal_count = 0;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v) || !truth.has_sample(u, v)) continue;
      const double error =
          (view.range(u, v) - truth.range(u, v)) * view.camera.ray(u, v).direction.norm();
      errors.depth_rms += error * error;
      ++samples;
      if (surface(u, v).allFinite()) {
        errors.surface_normals += angle(surface(u, v), truth.normals(u, v));
        ++surface_count;
      }
      if (view.has_normal(u, v)) {
        errors.normals += angle(view.normals(u, v), truth.normals(u, v));
        ++normal_count;
      }
    }
  }
  errors.depth_rms = std::sqrt(errors.depth_rms / static_cast<double>(samples));
  errors.surface_normals /= static_cast<double>(surface_count);
  errors.normals /= static_cast<double>(normal_count);
  return errors;
}

}  // namespace relief::testing
