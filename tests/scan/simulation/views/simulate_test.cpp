#include "relief/simulation/simulate.h"

#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "scan/simulation/objects/built_in_object.h"
#include "scan/simulation/views/view_layout.h"
#include "tests/support/result_matchers.h"

namespace relief::simulation {
namespace {

SimulationOptions small_options() {
  SimulationOptions options;
  options.views = 7;
  options.width = 96;
  options.height = 80;
  options.mesh_divisions = 8;
  return options;
}

bool same_bytes(const RangeView& a, const RangeView& b) {
  return a.range.size() == b.range.size() &&
         std::memcmp(a.range.data(), b.range.data(), a.range.size() * sizeof(double)) == 0 &&
         std::memcmp(a.normals.data(), b.normals.data(),
                     a.normals.size() * sizeof(Eigen::Vector3f)) == 0 &&
         a.world_from_view.matrix() == b.world_from_view.matrix();
}

TEST(Simulate, GivesScansAndTruthOfTheSameSamples) {
  const auto simulation = value_of(simulate(small_options()));
  ASSERT_EQ(simulation.scans.views.size(), 7u);
  EXPECT_EQ(simulation.scans.unit, "mm");
  EXPECT_EQ(simulation.mesh.faces.size(), 20u * 64u);
  for (std::size_t i = 0; i < 7; ++i) {
    const RangeView& scan = simulation.scans.views[i];
    const RangeView& truth = simulation.truth.views[i];
    EXPECT_EQ(scan.name, truth.name);
    EXPECT_EQ(truth.pose, PoseKind::kKnown);
    EXPECT_EQ(scan.sample_count(), truth.sample_count());
    EXPECT_GT(truth.sample_count(), 1000u);
    EXPECT_TRUE(scan.has_normals());
  }
}

TEST(Simulate, TruthLiesOnTheObject) {
  const auto simulation = value_of(simulate(small_options()));
  const AnalyticSurface owl = built_in_object();
  for (const RangeView& view : simulation.truth.views) {
    for (int v = 0; v < view.height(); ++v) {
      for (int u = 0; u < view.width(); ++u) {
        if (!view.has_sample(u, v)) continue;
        const Eigen::Vector3d point = view.world_from_view * view.point(u, v);
        EXPECT_LT(std::abs(owl.value(point)), 1e-10);
        const Eigen::Vector3d normal =
            view.world_from_view.linear() * view.normals(u, v).cast<double>();
        EXPECT_LT((normal - unit_normal(owl, point)).norm(), 1e-6);
        EXPECT_LT(view.normals(u, v).cast<double>().dot(view.camera.ray(u, v).direction), 0.0);
      }
    }
  }
}

TEST(Simulate, NoiseHasTheStatedSizeInSampleSpacings) {
  const auto simulation = value_of(simulate(small_options()));
  double squares = 0.0, count = 0.0;
  for (std::size_t i = 0; i < simulation.scans.views.size(); ++i) {
    const RangeView &scan = simulation.scans.views[i], &truth = simulation.truth.views[i];
    for (int v = 0; v < scan.height(); ++v) {
      for (int u = 0; u < scan.width(); ++u) {
        if (!scan.has_sample(u, v)) continue;
        squares += (scan.point(u, v) - truth.point(u, v)).squaredNorm();
        count += 1.0;
      }
    }
  }
  const double spacing = sample_spacing(simulation.truth.views[0]);
  EXPECT_NEAR(std::sqrt(squares / count), simulation.range_sigma, 0.02 * simulation.range_sigma);
  EXPECT_NEAR(simulation.spacing, spacing, 0.25 * spacing);
}

TEST(Simulate, PosesAreOffByTheStatedAmounts) {
  SimulationOptions options = small_options();
  options.pose_rotation_deg = 3.0;
  options.pose_translation = 0.02;
  const auto simulation = value_of(simulate(options));
  const auto& scans = simulation.scans.views;
  const auto& truth = simulation.truth.views;
  EXPECT_EQ(scans[0].pose, PoseKind::kKnown);
  EXPECT_TRUE(scans[0].world_from_view.isApprox(truth[0].world_from_view, 0.0));
  for (std::size_t i = 1; i < scans.size(); ++i) {
    EXPECT_EQ(scans[i].pose, PoseKind::kGuess);
    const RigidMotion error = scans[i].world_from_view * truth[i].world_from_view.inverse();
    EXPECT_NEAR(rotation_angle(error) * 180.0 / std::acos(-1.0), 3.0, 1e-9);
    EXPECT_NEAR(error.translation().norm(), 0.02 * simulation.diameter, 1e-9);
  }
}

TEST(Simulate, PosesMayBeKnownOrAbsent) {
  SimulationOptions options = small_options();
  options.views = 2;
  options.pose = PoseKind::kKnown;
  const auto known = simulate(options);
  options.pose = PoseKind::kAbsent;
  const auto absent = simulate(options);
  ASSERT_TRUE(known && absent);
  EXPECT_TRUE(
      known->scans.views[1].world_from_view.isApprox(known->truth.views[1].world_from_view, 0.0));
  for (const auto& view : absent->scans.views) {
    EXPECT_EQ(view.pose, PoseKind::kAbsent);
    EXPECT_TRUE(view.world_from_view.isApprox(RigidMotion::Identity(), 0.0));
  }
}

TEST(Simulate, SameSeedGivesTheSameBytesAtAnyThreadCount) {
  SimulationOptions options = small_options();
  const auto one = simulate(options, {.threads = 1});
  const auto three = simulate(options, {.threads = 3});
  options.seed = 2;
  const auto other = simulate(options);
  ASSERT_TRUE(one && three && other);
  for (std::size_t i = 0; i < one->scans.views.size(); ++i) {
    EXPECT_TRUE(same_bytes(one->scans.views[i], three->scans.views[i]));
    EXPECT_FALSE(same_bytes(one->scans.views[i], other->scans.views[i]));
    EXPECT_TRUE(same_bytes(one->truth.views[i], other->truth.views[i]));
  }
}

class SimulateInALayout : public ::testing::TestWithParam<ViewLayout> {};
INSTANTIATE_TEST_SUITE_P(Layouts, SimulateInALayout,
                         ::testing::Values(ViewLayout::kTurntable, ViewLayout::kSphere),
                         [](const auto& test) -> std::string {
                           return test.param == ViewLayout::kSphere ? "Sphere" : "Turntable";
                         });

TEST_P(SimulateInALayout, ViewsTogetherSeeNearlyTheWholeObject) {
  SimulationOptions options = small_options();
  options.views = 12;
  options.layout = GetParam();
  const auto simulation = value_of(simulate(options));
  const TriangleMesh mesh = built_in_truth_mesh(24);
  std::size_t seen = 0;
  for (const auto& vertex : mesh.vertices) {
    bool visible = false;
    for (const RangeView& view : simulation.truth.views) {
      const Eigen::Vector3d point = view.world_from_view.inverse() * vertex;
      const auto pixel = view.camera.project(point);
      const int u = static_cast<int>(std::lround(pixel->x()));
      const int v = static_cast<int>(std::lround(pixel->y()));
      if (view.has_sample(u, v) && std::abs(view.range(u, v) - point.z()) < 2.0) visible = true;
    }
    seen += visible;
  }
  EXPECT_GT(static_cast<double>(seen), 0.98 * static_cast<double>(mesh.vertices.size()));
}

SimulationOptions realistic_options() {
  SimulationOptions options = small_options();
  options.views = 3;
  options.range_sensor = structured_light_scanner();
  options.normal_sensor = PhotometricStereo{};
  options.reflectance = patchy_surface();
  return options;
}

TEST(Simulate, RealisticSensorsLoseSamplesButInventNone) {
  const auto simulation = value_of(simulate(realistic_options()));
  for (std::size_t i = 0; i < simulation.scans.views.size(); ++i) {
    const RangeView &scan = simulation.scans.views[i], &truth = simulation.truth.views[i];
    EXPECT_LT(scan.sample_count(), truth.sample_count());
    EXPECT_GT(scan.sample_count(), truth.sample_count() / 2);
    for (int v = 0; v < scan.height(); ++v) {
      for (int u = 0; u < scan.width(); ++u) {
        if (scan.has_sample(u, v)) {
          EXPECT_TRUE(truth.has_sample(u, v));
        }
        if (scan.has_normal(u, v)) {
          EXPECT_TRUE(scan.has_sample(u, v));
          EXPECT_LT(scan.normals(u, v).cast<double>().dot(scan.camera.ray(u, v).direction), 0.0);
        }
      }
    }
  }
}

TEST(Simulate, RealisticSensorsDoNotDependOnThreads) {
  SimulationOptions options = realistic_options();
  const auto one = value_of(simulate(options, {.threads = 1}));
  for (const int threads : {2, 4}) {
    const auto other = value_of(simulate(options, {.threads = threads}));
    for (std::size_t i = 0; i < one.scans.views.size(); ++i)
      EXPECT_TRUE(same_bytes(one.scans.views[i], other.scans.views[i]));
  }
}

TEST(Simulate, SensorsMayBeExactOrLeaveOutNormals) {
  SimulationOptions options = small_options();
  options.range_sensor = WhiteRangeSensor{0.0};
  options.normal_sensor = WhiteNormalSensor{0.0, 0.0};
  const auto exact = simulate(options);
  options.normal_sensor = NoNormalSensor{};
  const auto bare = simulate(options);
  ASSERT_TRUE(exact && bare);
  RangeView scan = exact->scans.views[2];
  scan.world_from_view = exact->truth.views[2].world_from_view;
  EXPECT_TRUE(same_bytes(scan, exact->truth.views[2]));
  EXPECT_FALSE(bare->scans.views[2].has_normals());
  EXPECT_TRUE(bare->truth.views[2].has_normals());
}

// The same object a thousand times smaller gives the same scans a thousand times smaller.
TEST(Simulate, DoesNotDependOnTheUnit) {
  const auto ball = [](double scale) {
    const AnalyticSurface sphere = sphere_surface(scale);
    SimulationObject object;
    object.radius = 1.5 * scale;
    object.cast = [sphere](const Ray& ray) -> std::optional<SurfaceHit> {
      const auto t = intersect(sphere, ray);
      if (!t) return std::nullopt;
      return SurfaceHit{*t, unit_normal(sphere, ray.at(*t))};
    };
    return object;
  };
  for (const SensorRays rays :
       {SensorRays::kPinhole, SensorRays::kOrthographic, SensorRays::kLine}) {
    SimulationOptions options = realistic_options();
    options.rays = rays;
    const auto large = simulate(ball(50.0), options), small = simulate(ball(0.05), options);
    ASSERT_TRUE(large && small);
    double differing = 0.0, samples = 0.0;
    for (std::size_t i = 0; i < large->scans.views.size(); ++i) {
      const RangeView &a = large->scans.views[i], &b = small->scans.views[i];
      for (std::size_t pixel = 0; pixel < a.range.size(); ++pixel) {
        const bool sampled = a.range[pixel] == a.range[pixel];
        samples += sampled;
        if (sampled != (b.range[pixel] == b.range[pixel])) differing += 1.0;
        // Rounding may move a disparity to the next step.
        if (sampled &&
            !(std::abs(a.range[pixel] - 1000.0 * b.range[pixel]) < 1e-9 * a.range[pixel]))
          differing += 1.0;
      }
    }
    EXPECT_GT(samples, 1000.0);
    EXPECT_LT(differing, 0.001 * samples);
  }
}

TEST(Simulate, StandsWhereItIsTold) {
  SimulationOptions options = small_options();
  options.pose = PoseKind::kKnown;
  options.poses = {{"left", camera_looking_at({-300, 0, 50}, {0, 0, 0})},
                   {"right", camera_looking_at({310, 0, 0}, {0, 0, 0})}};
  const auto simulation = value_of(simulate(options));
  ASSERT_EQ(simulation.scans.views.size(), 2u);
  EXPECT_EQ(simulation.scans.views[1].name, "right");
  EXPECT_NEAR(simulation.distance, 310.0, 1e-9);
  EXPECT_TRUE(simulation.scans.views[0].world_from_view.isApprox(options.poses[0].world_from_view));
  options.poses[1].world_from_view.translation() = Eigen::Vector3d(1, 2, 3);
  EXPECT_THAT(simulate(options), HasError("right"));
}

TEST(Simulate, NamesAnOptionOutOfItsRange) {
  SimulationOptions options = small_options();
  options.range_sensor = WhiteRangeSensor{-0.1};
  EXPECT_THAT(simulate(options), HasError(ErrorKind::kBadInput, "range noise", "-0.1"));
}

TEST(Simulate, StopsWhenAsked) {
  const auto stopped =
      simulate(small_options(),
               {.progress = [](double fraction, std::string_view) { return fraction < 0.3; }});
  EXPECT_THAT(stopped, HasError(ErrorKind::kInterrupted));
}

TEST(Simulate, TakesAnyObject) {
  const AnalyticSurface sphere = sphere_surface(0.05);
  SimulationObject object;
  object.unit = "m";
  object.centre = {1, 2, 3};
  object.radius = 0.05;
  object.cast = [&](const Ray& ray) -> std::optional<SurfaceHit> {
    const Ray centred{ray.origin - object.centre, ray.direction};
    const auto t = intersect(sphere, centred);
    if (!t) return std::nullopt;
    return SurfaceHit{*t, unit_normal(sphere, centred.at(*t))};
  };
  const auto simulation = value_of(simulate(object, small_options()));
  EXPECT_EQ(simulation.truth.unit, "m");
  for (const RangeView& view : simulation.truth.views)
    EXPECT_NEAR((view.world_from_view * view.point(48, 40) - object.centre).norm(), 0.05, 1e-12);
}

}  // namespace
}  // namespace relief::simulation
