#include "scan/simulation/sensors/photometric_stereo.h"

#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "relief/simulation/normal_sensors.h"
#include "scan/base/linear_algebra.h"
#include "tests/scan/simulation/sensor_bench.h"
#include "tests/support/degree.h"
#include "tests/support/result_matchers.h"

namespace relief::simulation {
namespace {

using testing::angle_between;
using testing::kDegree;
using testing::perfect_shading;
using testing::SensorBench;

RangeView shaded(const SensorBench& bench, const PhotometricStereo& camera, int view = 0) {
  RangeView scan = bench.truth;
  scan_by_shading(scan, camera, bench.scene(view));
  return scan;
}

double rms_angle(const RangeView& scan, const RangeView& truth) {
  double squares = 0.0, count = 0.0;
  for (int v = 0; v < scan.height(); ++v) {
    for (int u = 0; u < scan.width(); ++u) {
      if (!scan.has_normal(u, v)) continue;
      squares += std::pow(angle_between(scan.normals(u, v), truth.normals(u, v)), 2);
      count += 1.0;
    }
  }
  return std::sqrt(squares / count);
}

// Normals up to 60 degrees from the axis and more.
testing::Surface ball() { return testing::sphere({0, 0, 10}, 1.0); }
testing::Surface frontal_wall() { return testing::plane({0, 0, 10}, {0, 0, -1}); }

// A wall with a slab before its right half, which shades the wall beside it.
testing::Surface step() {
  const auto near = testing::plane({0, 0, 9.5}, {0, 0, -1}), far = frontal_wall();
  const auto side = testing::plane({0.305, 0, 0}, {-1, 0, 0});
  return [=](const Ray& ray) {
    auto hit = near(ray);
    if (hit && ray.at(hit->t).x() > 0.305) return hit;
    hit = side(ray);
    if (hit && hit->t > 0.0 && ray.at(hit->t).z() > 9.5 && ray.at(hit->t).z() < 10.0 &&
        ray.direction.x() > 0.0)
      return hit;
    return far(ray);
  };
}

TEST(PhotometricStereo, IsExactWithoutErrors) {
  const SensorBench bench(ball());
  const RangeView scan = shaded(bench, perfect_shading());
  EXPECT_LT(rms_angle(scan, bench.truth), 1e-6);
  double with = 0.0, all = 0.0;
  for (std::size_t i = 0; i < scan.normals.size(); ++i) {
    with += scan.normals[i].allFinite();
    all += bench.truth.normals[i].allFinite();
  }
  EXPECT_GT(with, 0.95 * all);  // all but where fewer than three lights reach
}

TEST(PhotometricStereo, NoiseHasTheStatedDeviationAboutEachAxis) {
  const SensorBench bench(frontal_wall());
  for (const auto& [lights, light_angle] : {std::pair{3, 20.0}, {8, 35.0}, {12, 50.0}}) {
    PhotometricStereo camera = perfect_shading();
    camera.lights = lights;
    camera.light_angle_deg = light_angle;
    camera.noise_deg = 0.8;
    const double expected = 0.8 * kDegree * std::sqrt(2.0);
    EXPECT_NEAR(rms_angle(shaded(bench, camera), bench.truth), expected, 0.02 * expected);
  }
}

TEST(PhotometricStereo, DarkSurfacesAreNoisier) {
  Reflectance reflectance;
  reflectance.dark_fraction = 1.0 - 1e-12;
  reflectance.dark_albedo = 0.2;
  const SensorBench bench(frontal_wall(), SensorBench::default_camera(), reflectance);
  PhotometricStereo camera = perfect_shading();
  camera.noise_deg = 0.3;
  const double expected = 0.3 / 0.2 * kDegree * std::sqrt(2.0);
  EXPECT_NEAR(rms_angle(shaded(bench, camera), bench.truth), expected, 0.02 * expected);
}

TEST(NormalDistortion, HasTheStatedRmsOverAllDirections) {
  PhotometricStereo camera;
  camera.distortion_deg = 1.0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Eigen::Matrix3d distortion = normal_distortion(camera, {seed, 3});
    double squares = 0.0;
    constexpr int kCount = 4000;
    for (int i = 0; i < kCount; ++i) {
      const double z = 1.0 - (2.0 * i + 1.0) / kCount, turn = 2.4 * i, r = std::sqrt(1.0 - z * z);
      const Eigen::Vector3d n(r * std::cos(turn), r * std::sin(turn), z);
      const Eigen::Vector3d turned = distortion * n;
      squares += std::pow(std::atan2(n.cross(turned).norm(), n.dot(turned)), 2) / kCount;
    }
    EXPECT_NEAR(std::sqrt(squares), kDegree, 0.02 * kDegree);
  }
}

TEST(PhotometricStereo, WrongLightsDistortTheNormalsLinearly) {
  const SensorBench bench(ball());
  PhotometricStereo camera = perfect_shading();
  camera.distortion_deg = 4.0;
  const RangeView scan = shaded(bench, camera), again = shaded(bench, camera, 7);
  const Eigen::Matrix3d distortion =
      normal_distortion(camera, bench.scene().of_sensor(kNormalDistortion));
  for (int v = 80; v < 160; v += 3) {
    for (int u = 120; u < 200; u += 3) {
      if (!scan.has_normal(u, v)) continue;
      const Eigen::Vector3d n = bench.truth.normals(u, v).cast<double>();
      if (n.z() > -std::sin(40.0 * kDegree)) continue;  // a light may not reach
      const Eigen::Vector3d expected = (distortion * n).normalized();
      EXPECT_LT((expected - scan.normals(u, v).cast<double>()).norm(), 1e-6);
    }
  }
  EXPECT_EQ(std::memcmp(scan.normals.data(), again.normals.data(),
                        scan.normals.size() * sizeof(Eigen::Vector3f)),
            0);
}

// The least-squares solution with the readings that the shadows leave, by another route.
Eigen::Vector3d solved(const PhotometricStereo& camera, const Eigen::Vector3d& normal,
                       const std::vector<bool>& lit, double in_shadow) {
  const auto lights = light_directions(camera);
  Eigen::MatrixX3d matrix(lights.size(), 3);
  Eigen::VectorXd readings(lights.size());
  for (std::size_t k = 0; k < lights.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    matrix.row(row) = lights[k].transpose();
    readings[row] = lit[k] && normal.dot(lights[k]) > 0.0 ? normal.dot(lights[k]) : in_shadow;
  }
  return solve_symmetric(Eigen::Matrix3d(matrix.transpose() * matrix),
                         Eigen::Vector3d(matrix.transpose() * readings))
      .normalized();
}

TEST(PhotometricStereo, AttachedShadowsThatAreNotNoticedTurnTheNormals) {
  const SensorBench bench(ball());
  PhotometricStereo camera = perfect_shading();
  camera.interreflection = 0.1;
  camera.shadow_threshold = 0.0;
  const RangeView scan = shaded(bench, camera);
  double largest = 0.0;
  for (int v = 0; v < scan.height(); v += 2) {
    for (int u = 0; u < scan.width(); u += 2) {
      if (!scan.has_normal(u, v)) continue;
      const Eigen::Vector3d n = bench.truth.normals(u, v).cast<double>();
      const Eigen::Vector3d expected = solved(camera, n, std::vector<bool>(8, true), 0.1);
      const Eigen::Vector3d ray = bench.truth.camera.ray(u, v).direction;
      if (expected.dot(ray) > -0.01 || std::abs(n.z()) < 0.1) continue;
      EXPECT_LT((expected - scan.normals(u, v).cast<double>()).norm(), 1e-5);
      largest = std::max(largest, (expected - n).norm());
    }
  }
  EXPECT_GT(largest, 5.0 * kDegree);
}

TEST(PhotometricStereo, CastShadowsTurnNormalsWhereTheyFall) {
  const SensorBench bench(step());
  PhotometricStereo camera = perfect_shading();
  camera.interreflection = 0.1;
  camera.shadow_threshold = 0.0;
  const RangeView scan = shaded(bench, camera);
  const auto lights = light_directions(camera);
  const int v = 120;
  int turned = 0;
  for (int u = 0; u < scan.width(); ++u) {
    const Eigen::Vector3d point = bench.truth.point(u, v);
    if (std::abs(point.z() - 10.0) > 1e-9) continue;
    std::vector<bool> lit;
    for (const auto& light : lights) {
      // The light's ray rises 0.5 before the wall at this sideways distance.
      const double x = point.x() + 0.5 / -light.z() * light.x();
      lit.push_back(x < 0.305);
    }
    const Eigen::Vector3d expected = solved(camera, {0, 0, -1}, lit, 0.1);
    EXPECT_LT((expected - scan.normals(u, v).cast<double>()).norm(), 1e-5) << u;
    turned += (expected - Eigen::Vector3d(0, 0, -1)).norm() > 3.0 * kDegree;
  }
  EXPECT_GT(turned, 5);
}

TEST(PhotometricStereo, ShadowsThatAreNoticedDoNoHarm) {
  const SensorBench bench(step());
  PhotometricStereo camera = perfect_shading();
  camera.interreflection = 0.05;
  camera.shadow_threshold = 0.1;
  const RangeView scan = shaded(bench, camera);
  for (int v = 100; v < 140; ++v) {
    for (int u = 0; u < scan.width(); ++u) {
      if (std::abs(bench.truth.range(u, v) - 10.0) > 1e-9 || !scan.has_normal(u, v)) continue;
      EXPECT_LT(angle_between(scan.normals(u, v), bench.truth.normals(u, v)), 1e-5);
    }
  }
}

TEST(PhotometricStereo, HighlightsTurnNormalsWhereTheSurfaceMirrorsALight) {
  Reflectance reflectance;
  reflectance.glossy_fraction = 1.0 - 1e-12;
  const SensorBench bench(ball(), SensorBench::default_camera(), reflectance);
  const PhotometricStereo camera = perfect_shading();
  const RangeView scan = shaded(bench, camera);
  const auto lights = light_directions(camera);
  double in = 0.0, in_turned = 0.0, out = 0.0, out_turned = 0.0;
  for (int v = 0; v < scan.height(); ++v) {
    for (int u = 0; u < scan.width(); ++u) {
      if (!scan.has_normal(u, v)) continue;
      const Eigen::Vector3d n = bench.truth.normals(u, v).cast<double>();
      if (n.z() > -std::sin(40.0 * kDegree)) continue;
      double nearest = std::numbers::pi;
      for (const auto& light : lights) {
        const Eigen::Vector3d half =
            (light - bench.truth.camera.ray(u, v).direction.normalized()).normalized();
        nearest = std::min(nearest, std::acos(std::min(1.0, n.dot(half))));
      }
      const double angle = angle_between(scan.normals(u, v), bench.truth.normals(u, v));
      if (nearest < 5.0 * kDegree) {
        in += 1.0;
        in_turned += angle > 3.0 * kDegree;
      } else if (nearest > 25.0 * kDegree) {
        out += 1.0;
        out_turned += angle > 0.1 * kDegree;
      }
    }
  }
  EXPECT_GT(in, 100.0);
  EXPECT_GT(in_turned, 0.7 * in);
  EXPECT_GT(out, 100.0);
  EXPECT_EQ(out_turned, 0.0);
}

TEST(PhotometricStereo, SmoothBiasHasTheStatedRms) {
  const SensorBench bench(frontal_wall());
  PhotometricStereo camera = perfect_shading();
  camera.bias_deg = 3.0;
  EXPECT_NEAR(rms_angle(shaded(bench, camera), bench.truth), 3.0 * kDegree, 0.03 * kDegree);
}

TEST(PhotometricStereo, DoesNotDependOnThreads) {
  const SensorBench bench(ball(), SensorBench::default_camera(), patchy_surface());
  SensorScene scene = bench.scene();
  RangeView one = bench.truth;
  on_threads(1, [&] { scan_by_shading(one, {}, scene); });
  for (const int threads : {2, 4}) {
    RangeView other = bench.truth;
    on_threads(threads, [&] { scan_by_shading(other, {}, scene); });
    EXPECT_EQ(std::memcmp(one.normals.data(), other.normals.data(),
                          one.normals.size() * sizeof(Eigen::Vector3f)),
              0);
  }
}

TEST(PhotometricStereo, NamesAFieldOutOfItsRange) {
  PhotometricStereo camera;
  camera.lights = 2;
  EXPECT_THAT(validate(camera), HasError("lights"));
}

}  // namespace
}  // namespace relief::simulation
