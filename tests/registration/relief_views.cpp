#include "tests/registration/relief_views.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <Eigen/Geometry>

namespace relief::testing {

namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

struct Wave {
  Eigen::Vector3d frequency;  // [rad/unit]
  double phase, slope;
};

std::vector<Wave> random_waves(const EngravingOptions& options) {
  constexpr int kWaves = 60;
  std::mt19937 generator(options.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<Wave> waves;
  for (int i = 0; i < kWaves; ++i) {
    const double x = normal(generator), y = normal(generator), z = normal(generator);
    const double length =
        options.shortest * std::pow(options.longest / options.shortest, uniform(generator));
    waves.push_back({2.0 * std::numbers::pi / length * Eigen::Vector3d(x, y, z).normalized(),
                     2.0 * std::numbers::pi * uniform(generator),
                     // Two thirds of a wave's slope lie in the surface, half of its square remains.
                     options.slope_deg * kRadians * std::sqrt(3.0 / kWaves)});
  }
  return waves;
}

}  // namespace

Surface engraved(const Surface& surface, const EngravingOptions& options) {
  return [surface, waves = random_waves(options)](const Ray& ray) -> std::optional<SurfaceHit> {
    auto hit = surface(ray);
    if (!hit) return hit;
    const Eigen::Vector3d point = ray.at(hit->t);
    Eigen::Vector3d slope = Eigen::Vector3d::Zero();
    for (const Wave& wave : waves)
      slope += wave.slope * std::cos(wave.frequency.dot(point) + wave.phase) *
               wave.frequency.normalized();
    slope -= slope.dot(hit->normal) * hit->normal;
    hit->normal = (hit->normal - slope).normalized();
    return hit;
  };
}

Surface cylinder(double radius) {
  return [radius](const Ray& ray) -> std::optional<SurfaceHit> {
    Eigen::Vector3d o = ray.origin, d = ray.direction;
    o.y() = d.y() = 0.0;
    const double a = d.squaredNorm(), b = d.dot(o);
    const double discriminant = b * b - a * (o.squaredNorm() - radius * radius);
    if (discriminant < 0.0) return std::nullopt;
    const double t = (-b - std::sqrt(discriminant)) / a;
    return SurfaceHit{t, (o + t * d) / radius};
  };
}

void add_flaws(RangeView& view, const SensorFlaws& flaws, std::uint32_t seed) {
  // A slowly varying turn: two waves about the length of the view for either component.
  std::mt19937 generator(seed + 1000);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::Matrix<double, 4, 3> waves;
  for (int i = 0; i < 4; ++i)
    waves.row(i) << 2.0 * std::numbers::pi * uniform(generator) / view.width(),
        2.0 * std::numbers::pi * uniform(generator) / view.height(), 3.0 * uniform(generator);
  const double amplitude = flaws.normal_bias_deg * kRadians / std::sqrt(2.0);
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_normal(u, v)) continue;
      const auto wave = [&](int i) {
        return amplitude * std::sin(waves(i, 0) * u + waves(i, 1) * v + waves(i, 2));
      };
      const Eigen::Vector3d turn(wave(0) + wave(1), wave(2) + wave(3), 0.0);
      if (turn.norm() > 0.0)
        view.normals(u, v) =
            (Eigen::AngleAxisd(turn.norm(), turn.normalized()) * view.normals(u, v).cast<double>())
                .cast<float>();
    }
  }
  add_range_noise(view, flaws.range_noise * sample_spacing(view), seed);
  add_normal_noise(view, flaws.normal_noise_deg * kRadians, seed + 500);
}

void add_smooth_noise(RangeView& view, double sigma, int reach, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, sigma * (2 * reach + 1));
  const int width = view.width(), height = view.height();
  Grid<double> noise(width, height, 0.0);
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = normal(generator);
  for (int v = reach; v + reach < height; ++v) {
    for (int u = reach; u + reach < width; ++u) {
      double sum = 0.0;
      for (int y = v - reach; y <= v + reach; ++y)
        for (int x = u - reach; x <= u + reach; ++x) sum += noise(x, y);
      const int samples = (2 * reach + 1) * (2 * reach + 1);
      view.range(u, v) += sum / samples / view.camera.ray(u, v).direction.norm();
    }
  }
}

double mean_displacement(const RangeView& view, const RigidMotion& a, const RigidMotion& b) {
  double sum = 0.0, count = 0.0;
  for (int v = 0; v < view.height(); v += 2) {
    for (int u = 0; u < view.width(); u += 2) {
      if (!view.has_sample(u, v)) continue;
      sum += (a * view.point(u, v) - b * view.point(u, v)).norm();
      count += 1.0;
    }
  }
  return count > 0.0 ? sum / count : 0.0;
}

}  // namespace relief::testing
