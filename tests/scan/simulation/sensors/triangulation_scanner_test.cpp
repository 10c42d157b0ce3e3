#include "scan/simulation/sensors/triangulation_scanner.h"

#include <cmath>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "relief/scan/context.h"
#include "relief/simulation/range_sensors.h"
#include "tests/scan/simulation/sensor_bench.h"
#include "tests/support/result_matchers.h"

namespace relief::simulation {
namespace {

using testing::perfect_scanner;
using testing::SensorBench;

RangeView scanned(const SensorBench& bench, const TriangulationScanner& scanner, int view = 0) {
  RangeView scan = bench.truth;
  scan_by_triangulation(scan, scanner, bench.scene(view));
  return scan;
}

testing::Surface frontal_plane(double z) { return testing::plane({0, 0, z}, {0, 0, -1}); }

double rms_error(const RangeView& scan, const RangeView& truth) {
  double squares = 0.0, count = 0.0;
  for (std::size_t i = 0; i < scan.range.size(); ++i) {
    if (scan.range[i] != scan.range[i]) continue;
    squares += std::pow(scan.range[i] - truth.range[i], 2);
    count += 1.0;
  }
  return std::sqrt(squares / count);
}

TEST(TriangulationScanner, IsExactWithoutErrors) {
  const SensorBench bench(testing::sphere({0, 0, 10}, 1.0));
  const RangeView scan = scanned(bench, perfect_scanner());
  EXPECT_LT(rms_error(scan, bench.truth), 1e-13);
  EXPECT_LT(scan.sample_count(), bench.truth.sample_count());  // the projector's shadow
}

// Equation (S5): sigma_z = z^2 / (f b) sigma_disparity, f = 500 pixels, b = 0.4 x 10.
TEST(TriangulationScanner, NoiseGrowsWithTheSquareOfTheDepth) {
  TriangulationScanner scanner = perfect_scanner();
  scanner.baseline = 0.4;
  scanner.disparity_noise = 0.2;
  for (const double z : {6.0, 10.0, 18.0}) {
    const SensorBench bench(frontal_plane(z));
    const double expected = z * z / (500.0 * 4.0) * 0.2;
    EXPECT_NEAR(rms_error(scanned(bench, scanner), bench.truth), expected, 0.03 * expected);
    EXPECT_NEAR(depth_deviation(scanner, z, 10.0, 0.02), expected, 1e-12);
  }
}

TEST(TriangulationScanner, NoiseGrowsAsTheSignalFalls) {
  TriangulationScanner scanner = perfect_scanner();
  scanner.disparity_noise = 0.1;
  scanner.noise_growth = 0.5;
  const SensorBench bench(testing::plane({0, 0, 10}, {1.2, -0.5, -1}));
  const RangeView scan = scanned(bench, scanner);
  const double scale = 500.0 * scanner.baseline * 10.0;
  const Eigen::Vector3d projector(scanner.baseline * 10.0, 0.0, 0.0);
  double squares = 0.0, count = 0.0;
  for (int v = 0; v < scan.height(); ++v) {
    for (int u = 0; u < scan.width(); ++u) {
      if (!scan.has_sample(u, v)) continue;
      const Eigen::Vector3d point = bench.truth.point(u, v);
      const Eigen::Vector3d normal = bench.truth.normals(u, v).cast<double>();
      const double signal =
          -normal.dot(point.normalized()) * normal.dot((projector - point).normalized());
      const double error = scale / scan.range(u, v) - scale / bench.truth.range(u, v);
      squares += error * error * signal / (0.1 * 0.1);
      count += 1.0;
    }
  }
  EXPECT_GT(count, 10000.0);
  EXPECT_NEAR(squares / count, 1.0, 0.05);
}

TEST(TriangulationScanner, NoiseIsCorrelatedOverTheStatedLength) {
  TriangulationScanner scanner = perfect_scanner();
  scanner.disparity_noise = 0.1;
  scanner.noise_correlation = 3.0;
  const SensorBench bench(frontal_plane(10.0));
  const RangeView scan = scanned(bench, scanner);
  const auto covariance = [&](int du, int dv) {
    double sum = 0.0, count = 0.0;
    for (int v = 0; v + dv < scan.height(); ++v)
      for (int u = 0; u + du < scan.width(); ++u, count += 1.0)
        sum += (scan.range(u, v) - 10.0) * (scan.range(u + du, v + dv) - 10.0);
    return sum / count;
  };
  for (const auto& [du, dv] : {std::pair{1, 0}, {0, 3}, {3, 0}, {2, 2}, {9, 0}})
    EXPECT_NEAR(covariance(du, dv) / covariance(0, 0), std::exp(-(du * du + dv * dv) / 9.0), 0.06);
}

TEST(TriangulationScanner, DisparitiesAreMultiplesOfTheStep) {
  TriangulationScanner scanner = perfect_scanner();
  scanner.disparity_noise = 0.05;
  scanner.disparity_step = 0.125;
  const SensorBench bench(testing::plane({0, 0, 10}, {0.4, 0.1, -1}));
  const RangeView scan = scanned(bench, scanner);
  const double scale = 500.0 * scanner.baseline * 10.0;
  for (std::size_t i = 0; i < scan.range.size(); i += 7) {
    const double steps = scale / scan.range[i] / 0.125;
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
    EXPECT_LT(std::abs(scale / scan.range[i] - scale / bench.truth.range[i]), 0.3 + 0.0625);
  }
}

// A sphere before a wall: the wall's samples are lost exactly where the segment to the projector
// passes the sphere.
TEST(TriangulationScanner, LosesWhatTheProjectorDoesNotReach) {
  const Eigen::Vector3d centre(0.2, -0.1, 8.0);
  const double radius = 0.4, wall_z = 11.0;
  const auto ball = testing::sphere(centre, radius), wall = frontal_plane(wall_z);
  const SensorBench bench([&](const Ray& ray) {
    const auto near = ball(ray);
    return near ? near : wall(ray);
  });
  TriangulationScanner scanner = perfect_scanner();
  scanner.baseline = 0.3;
  const RangeView scan = scanned(bench, scanner);
  const Eigen::Vector3d projector(3.0, 0.0, 0.0);
  int lost = 0;
  for (int v = 0; v < scan.height(); ++v) {
    for (int u = 0; u < scan.width(); ++u) {
      const Eigen::Vector3d point = bench.truth.point(u, v);
      if (point.z() < wall_z - 1e-9) continue;
      const Eigen::Vector3d along = (point - projector).normalized();
      const double miss = (centre - projector).cross(along).norm();
      if (std::abs(miss - radius) < 1e-9) continue;
      EXPECT_EQ(scan.has_sample(u, v), miss > radius) << u << " " << v;
      EXPECT_EQ(scan.has_normal(u, v), scan.has_sample(u, v));
      lost += miss < radius;
    }
  }
  EXPECT_GT(lost, 800);
}

// The rate at which samples are lost is the normal distribution function of the missing signal.
TEST(TriangulationScanner, LosesGrazingSamplesAtTheStatedRate) {
  TriangulationScanner scanner = perfect_scanner();
  scanner.least_signal = 0.3;
  scanner.signal_noise = 0.1;
  scanner.noise_correlation = 0.0;
  double expected = 0.0, variance = 0.0, lost = 0.0, steep_lost = 0.0, steep = 0.0, flat_lost = 0.0;
  const SensorBench bench(testing::sphere({0, 0, 10}, 1.5));
  const RangeView scan = scanned(bench, scanner);
  const Eigen::Vector3d projector(scanner.baseline * 10.0, 0.0, 0.0);
  for (int v = 0; v < scan.height(); ++v) {
    for (int u = 0; u < scan.width(); ++u) {
      if (!bench.truth.has_sample(u, v)) continue;
      const Eigen::Vector3d point = bench.truth.point(u, v);
      const Eigen::Vector3d normal = bench.truth.normals(u, v).cast<double>();
      const double at_camera = -normal.dot(point.normalized());
      const double at_projector = normal.dot((projector - point).normalized());
      if (at_projector <= 0.0) {
        EXPECT_FALSE(scan.has_sample(u, v));
        continue;
      }
      const double p = 0.5 * std::erfc((at_camera * at_projector - 0.3) / 0.1 / std::sqrt(2.0));
      expected += p;
      variance += p * (1.0 - p);
      lost += !scan.has_sample(u, v);
      if (at_camera < 0.3 || at_projector < 0.3) {
        steep += 1.0;
        steep_lost += !scan.has_sample(u, v);
      }
      if (at_camera > 0.9 && at_projector > 0.9) flat_lost += !scan.has_sample(u, v);
    }
  }
  EXPECT_NEAR(lost, expected, 4.0 * std::sqrt(variance));
  EXPECT_GT(steep_lost, 0.5 * steep);
  EXPECT_EQ(flat_lost, 0.0);
}

TEST(TriangulationScanner, LosesTheSameDarkPatchInAllViews) {
  Reflectance reflectance;
  reflectance.dark_fraction = 0.3;
  reflectance.dark_albedo = 0.02;
  reflectance.patch_size = 0.3;
  TriangulationScanner scanner = perfect_scanner();
  scanner.least_signal = 0.1;
  const auto wall = testing::plane({0, 0, 0}, {0, 0, -1});
  const auto view_from = [&](const Eigen::Vector3d& eye) {
    const SensorBench bench(wall, SensorBench::default_camera(), reflectance,
                            testing::look_at(eye, {0, 0, 0}, Eigen::Vector3d::UnitY()));
    return scanned(bench, scanner);
  };
  const RangeView a = view_from({0, 0, -10}), b = view_from({3, 1, -9.5});
  double same = 0.0, lost = 0.0, total = 0.0;
  for (double x = -1.5; x < 1.5; x += 0.05) {
    for (double y = -1.5; y < 1.5; y += 0.05) {
      const auto sees = [&](const RangeView& view) {
        const auto pixel =
            view.camera.project(view.world_from_view.inverse() * Eigen::Vector3d(x, y, 0));
        return view.has_sample(static_cast<int>(std::lround(pixel->x())),
                               static_cast<int>(std::lround(pixel->y())));
      };
      same += sees(a) == sees(b);
      lost += !sees(a);
      total += 1.0;
    }
  }
  EXPECT_GT(lost, 0.1 * total);
  EXPECT_LT(lost, 0.5 * total);
  EXPECT_GT(same, 0.96 * total);
}

TEST(TriangulationScanner, LosesHighlights) {
  Reflectance reflectance;
  reflectance.glossy_fraction = 1.0 - 1e-12;
  TriangulationScanner scanner = perfect_scanner();
  scanner.saturation = 1.5;
  const SensorBench bench(testing::sphere({0, 0, 10}, 1.0), SensorBench::default_camera(),
                          reflectance);
  const RangeView scan = scanned(bench, scanner);
  const Eigen::Vector3d projector(scanner.baseline * 10.0, 0.0, 0.0);
  int lost = 0;
  for (int v = 0; v < scan.height(); ++v) {
    for (int u = 0; u < scan.width(); ++u) {
      if (!bench.truth.has_sample(u, v)) continue;
      const Eigen::Vector3d point = bench.truth.point(u, v);
      const Eigen::Vector3d normal = bench.truth.normals(u, v).cast<double>();
      const Eigen::Vector3d to_projector = (projector - point).normalized();
      const Eigen::Vector3d half = to_projector - point.normalized();
      const double off = std::acos(std::min(1.0, normal.dot(half.normalized())));
      if (off < 0.05) {
        EXPECT_FALSE(scan.has_sample(u, v));
        ++lost;
      } else if (off > 0.4 && normal.dot(to_projector) > 0.01) {
        EXPECT_TRUE(scan.has_sample(u, v));
      }
    }
  }
  EXPECT_GT(lost, 10);
}

// A step between two walls: samples fly only beside it, and only between the walls.
TEST(TriangulationScanner, SamplesBesideAnEdgeLieBetweenItsSides) {
  const auto near = frontal_plane(9.0), far = frontal_plane(10.0);
  const SensorBench bench([&](const Ray& ray) {
    const auto hit = near(ray);
    return hit && ray.at(hit->t).y() < 0.005 ? hit : far(ray);
  });
  TriangulationScanner scanner = perfect_scanner();
  scanner.flying_fraction = 0.4;
  const RangeView scan = scanned(bench, scanner);
  double beside = 0.0, flying = 0.0;
  for (int v = 0; v < scan.height(); ++v) {
    for (int u = 0; u < scan.width(); ++u) {
      if (!scan.has_sample(u, v)) continue;
      const double z = bench.truth.range(u, v);
      const bool at_edge = (v > 0 && bench.truth.range(u, v - 1) != z) ||
                           (v + 1 < scan.height() && bench.truth.range(u, v + 1) != z);
      const bool off = std::abs(scan.range(u, v) - z) > 1e-9;
      EXPECT_LE(off, at_edge);
      EXPECT_GT(scan.range(u, v), 9.0 - 1e-9);
      EXPECT_LT(scan.range(u, v), 10.0 + 1e-9);
      beside += at_edge;
      flying += off;
    }
  }
  EXPECT_GE(beside, 320.0);
  EXPECT_NEAR(flying / beside, 0.4, 4.0 * std::sqrt(0.24 / beside));
}

TEST(TriangulationScanner, WarpsAllViewsAlikeByTheStatedAmount) {
  TriangulationScanner scanner = perfect_scanner();
  scanner.warp = 2.0;
  const SensorBench bench(frontal_plane(10.0));
  const RangeView first = scanned(bench, scanner, 0), second = scanned(bench, scanner, 5);
  EXPECT_NEAR(rms_error(first, bench.truth), 2.0 * 0.02, 1e-4);
  EXPECT_EQ(std::memcmp(first.range.data(), second.range.data(), 8 * first.range.size()), 0);
  const SensorBench nearer(testing::plane({0, 0, 9}, {0.1, 0, -1}));
  const RangeView third = scanned(nearer, scanner);
  for (int v = 0; v < 240; v += 17)
    EXPECT_NEAR(third.range(100, v) - nearer.truth.range(100, v), first.range(100, v) - 10.0,
                1e-12);
}

TEST(TriangulationScanner, DoesNotDependOnThreads) {
  const SensorBench bench(testing::sphere({0, 0, 10}, 1.2), SensorBench::default_camera(),
                          patchy_surface());
  SensorScene scene = bench.scene();
  RangeView one = bench.truth;
  on_threads(1, [&] { scan_by_triangulation(one, structured_light_scanner(), scene); });
  for (const int threads : {2, 4}) {
    RangeView other = bench.truth;
    on_threads(threads, [&] { scan_by_triangulation(other, structured_light_scanner(), scene); });
    EXPECT_EQ(std::memcmp(one.range.data(), other.range.data(), 8 * one.range.size()), 0);
  }
}

TEST(TriangulationScanner, NamesAFieldOutOfItsRange) {
  TriangulationScanner scanner;
  scanner.flying_fraction = 1.5;
  EXPECT_THAT(validate(scanner), HasError("flying_fraction"));
  EXPECT_TRUE(validate(structured_light_scanner()));
  EXPECT_TRUE(validate(laser_line_scanner()));
}

}  // namespace
}  // namespace relief::simulation
