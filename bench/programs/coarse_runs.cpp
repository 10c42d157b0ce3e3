// Alignment without poses, over and over: how many views are placed, and is any wrong?
//
//   relief_coarse_runs PROJECT [--truth FILE] [--poses absent|random] [--runs N] [--seed S]
//     shuffles the views of a project, takes their poses away or puts random ones in their place
//     as guesses, aligns, and compares with the poses of the project (or of FILE);
//   relief_coarse_runs --simulate [--mesh FILE ...] [--runs N] [--seed S]
//     scans the built-in object, random bodies and the meshes with random layouts, sensors, noise,
//     stray samples and now and then a view of another object, and does the same;
//   relief_coarse_runs --boxes [--runs N] [--seed S]
//     scans cubes and boxes so, whose views look alike from several sides: none may be placed
//     wrongly.
//
// One line per run and a summary. Exit status 1 if any view was placed wrongly.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "registration/verification/pose_evidence.h"
#include "relief/evaluation/pose_errors.h"
#include "relief/io/mesh_io.h"
#include "relief/io/project_io.h"
#include "relief/registration/align_views.h"
#include "relief/simulation/simulate.h"
#include "relief/simulation/simulation_object.h"
#include "scan/simulation/objects/geodesic_sphere.h"

namespace relief {
namespace {

constexpr double kWrongSpacings = 3.0;  // A view that is farther off was placed wrongly.
constexpr double kMustOverlap = 0.4;    // A view that shares as much with another must be placed.

using Generator = std::mt19937_64;

double uniform(Generator& generator, double low, double high) {
  return low + (high - low) * (static_cast<double>(generator() >> 11) * 0x1p-53);
}

std::size_t index_below(Generator& generator, std::size_t count) { return generator() % count; }

Eigen::Quaterniond random_rotation(Generator& generator) {  // Shoemake 1992
  const double a = uniform(generator, 0, 1), b = uniform(generator, 0, 2 * std::numbers::pi),
               c = uniform(generator, 0, 2 * std::numbers::pi);
  return {std::sqrt(a) * std::cos(c), std::sqrt(1 - a) * std::sin(b),
          std::sqrt(1 - a) * std::cos(b), std::sqrt(a) * std::sin(c)};
}

struct Scene {
  std::string name;
  ScanProject truth;          // Views at their true poses.
  std::vector<bool> foreign;  // Views of another object, which nothing may be aligned with.
};

struct Outcome {
  std::size_t views = 0, placed = 0, wrong = 0, missed = 0, beside = 0;
  double displacement = 0.0, spacing = 0.0, seconds = 0.0;
};

void shuffle(Scene& scene, Generator& generator) {
  for (std::size_t i = scene.truth.views.size(); i > 1; --i) {
    const std::size_t j = index_below(generator, i);
    std::swap(scene.truth.views[i - 1], scene.truth.views[j]);
    const bool foreign = scene.foreign[i - 1];
    scene.foreign[i - 1] = scene.foreign[j];
    scene.foreign[j] = foreign;
  }
}

std::vector<RangeView> without_poses(const ScanProject& truth, bool random, Generator& generator) {
  std::vector<RangeView> views = truth.views;
  for (RangeView& view : views) {
    view.pose = random ? PoseKind::kGuess : PoseKind::kAbsent;
    view.world_from_view = RigidMotion::Identity();
    if (!random) continue;
    const registration::ViewSurface surface(view);
    const double size = surface.radius();
    const Eigen::Vector3d place(uniform(generator, -size, size), uniform(generator, -size, size),
                                uniform(generator, -size, size));
    view.world_from_view = Eigen::Translation3d(place) * random_rotation(generator) *
                           Eigen::Translation3d(-surface.centre());
  }
  return views;
}

// Views of the object that share enough with another to have to be placed, and were not; beside
// counts those of them that were aligned to one another, in a group apart.
void count_missed(const Scene& scene, const registration::Alignment& alignment, Outcome& outcome) {
  std::vector<registration::ViewSurface> surfaces;
  for (const RangeView& view : scene.truth.views) surfaces.emplace_back(view);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (scene.foreign[i] || alignment.views[i].aligned) continue;
    for (std::size_t j = 0; j < surfaces.size(); ++j) {
      if (j == i || scene.foreign[j]) continue;
      const auto evidence = registration::judge_pose(
          surfaces[i], surfaces[j],
          scene.truth.views[j].world_from_view.inverse() * scene.truth.views[i].world_from_view);
      if (evidence.overlap < kMustOverlap) continue;
      ++outcome.missed;
      if (alignment.views[i].reason.find("aligned only to") != std::string::npos) ++outcome.beside;
      break;
    }
  }
}

Outcome run(Scene scene, bool random_poses, bool verbose, Generator& generator) {
  shuffle(scene, generator);
  const auto views = without_poses(scene.truth, random_poses, generator);
  const std::clock_t start = std::clock();
  const registration::Alignment alignment = registration::align_views(views).value();
  Outcome outcome;
  outcome.seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  outcome.views = views.size();
  ScanProject result;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!alignment.views[i].aligned) {
      if (verbose)
        std::printf("    %s: %s\n", views[i].name.c_str(), alignment.views[i].reason.c_str());
      continue;
    }
    ++outcome.placed;
    if (scene.foreign[i]) {
      ++outcome.wrong;
      continue;
    }
    result.views.push_back(views[i]);
    result.views.back().pose = PoseKind::kGuess;
    result.views.back().world_from_view = alignment.views[i].world_from_view;
    outcome.spacing = std::max(outcome.spacing, sample_spacing(views[i]));
  }
  count_missed(scene, alignment, outcome);
  if (result.views.size() < 2) return outcome;
  evaluation::PoseErrorOptions options;
  options.robust = true;
  const auto errors = evaluation::evaluate_poses(result, scene.truth, options).value();
  outcome.displacement = errors.max_displacement;
  for (const auto& view : errors.views)
    outcome.wrong += view.mean_displacement > kWrongSpacings * outcome.spacing ? 1 : 0;
  return outcome;
}

Scene project_scene(const std::string& path, const std::string& truth_file) {
  Scene scene{path, read_project(path).value(), {}};
  if (!truth_file.empty()) {
    const auto poses = read_poses(truth_file).value();
    for (RangeView& view : scene.truth.views)
      for (const NamedPose& pose : poses)
        if (pose.name == view.name) view.world_from_view = pose.world_from_view;
  }
  for (RangeView& view : scene.truth.views) view.pose = PoseKind::kKnown;
  scene.foreign.assign(scene.truth.views.size(), false);
  return scene;
}

// A body with bumps of random place and size, no two alike.
simulation::SimulationObject random_body(Generator& generator) {
  struct Bump {
    Eigen::Vector3d direction;
    double height, sharpness;
  };
  std::vector<Bump> bumps;
  for (int k = 0; k < 40; ++k)
    bumps.push_back({random_rotation(generator) * Eigen::Vector3d::UnitX(),
                     uniform(generator, -0.12, 0.2), uniform(generator, 4.0, 60.0)});
  const Eigen::Vector3d axes(uniform(generator, 0.6, 1.4), uniform(generator, 0.6, 1.4), 1.0);
  TriangleMesh mesh = simulation::geodesic_sphere(80);
  for (auto& vertex : mesh.vertices) {
    const Eigen::Vector3d direction = vertex.normalized();
    double radius = 1.0;
    for (const Bump& bump : bumps)
      radius += bump.height * std::exp(bump.sharpness * (direction.dot(bump.direction) - 1.0));
    vertex = 50.0 * radius * direction.cwiseProduct(axes);
  }
  return simulation::mesh_object(std::move(mesh)).value();
}

// A cube, a box with two square faces, or one with three lengths; up to twice as long as thick.
simulation::SimulationObject random_box(Generator& generator) {
  Eigen::Vector3d half = Eigen::Vector3d::Constant(30.0);
  const std::size_t other_sides = index_below(generator, 3);
  for (std::size_t k = 0; k < other_sides; ++k)
    half[static_cast<Eigen::Index>(k)] *= uniform(generator, 0.7, 1.4);
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner)
    mesh.vertices.push_back(half.cwiseProduct(
        Eigen::Vector3d(2 * (corner & 1) - 1, (corner & 2) - 1, (corner & 4) / 2 - 1)));
  mesh.faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return simulation::mesh_object(std::move(mesh)).value();
}

void add_strays(RangeView& view, double fraction, double depth, Generator& generator) {
  for (double& range : view.range)
    if (range == range && uniform(generator, 0, 1) < fraction)
      range += uniform(generator, -depth, depth);
}

simulation::SimulationOptions random_options(Generator& generator) {
  simulation::SimulationOptions options;
  options.views = 6 + static_cast<int>(index_below(generator, 9));
  options.width = options.height = 160 + 32 * static_cast<int>(index_below(generator, 5));
  options.layout = index_below(generator, 2) == 0 ? simulation::ViewLayout::kTurntable
                                                  : simulation::ViewLayout::kSphere;
  options.rays = static_cast<simulation::SensorRays>(index_below(generator, 3));
  options.normal_sensor = simulation::NoNormalSensor{};
  const std::size_t sensor = index_below(generator, 4);
  if (sensor == 0)
    options.range_sensor = simulation::structured_light_scanner();
  else if (sensor == 1)
    options.range_sensor = simulation::laser_line_scanner();
  else
    options.range_sensor = simulation::WhiteRangeSensor{uniform(generator, 0.0, 1.0)};
  options.pose = PoseKind::kKnown;
  options.mesh_divisions = 0;
  options.seed = generator();
  return options;
}

Scene scene_of_box(Generator& generator) {
  const simulation::SimulationObject box = random_box(generator);
  Scene scene{"box", simulation::simulate(box, random_options(generator)).value().scans, {}};
  scene.foreign.assign(scene.truth.views.size(), false);
  return scene;
}

Scene simulated_scene(const std::vector<simulation::SimulationObject>& objects,
                      const std::vector<std::string>& names, Generator& generator) {
  const std::size_t which = index_below(generator, objects.size() + 1);
  const bool body = which == objects.size();
  const simulation::SimulationObject object = body ? random_body(generator) : objects[which];
  const simulation::SimulationOptions options = random_options(generator);
  simulation::Simulation simulation = simulation::simulate(object, options).value();
  Scene scene{body ? "random body" : names[which], std::move(simulation.scans), {}};
  scene.foreign.assign(scene.truth.views.size(), false);
  if (index_below(generator, 3) == 0) {  // A view that does not belong.
    simulation::SimulationObject other = random_body(generator);
    const double scale = object.radius / other.radius;
    for (auto& vertex : other.mesh.vertices) vertex *= scale;
    other = simulation::mesh_object(other.mesh).value();
    simulation::SimulationOptions single = random_options(generator);
    single.views = 1;
    auto foreign = simulation::simulate(other, single).value().scans;
    foreign.views[0].name = "foreign";
    scene.truth.views.push_back(std::move(foreign.views[0]));
    scene.foreign.push_back(true);
  }
  if (index_below(generator, 2) == 0) {
    const double fraction = uniform(generator, 0.0, 0.05);
    for (RangeView& view : scene.truth.views)
      add_strays(view, fraction, 0.3 * object.radius, generator);
  }
  return scene;
}

struct Settings {
  std::string project, truth, poses = "absent";
  bool simulate = false, boxes = false, verbose = false;
  std::vector<std::string> meshes;
  int runs = 20;
  std::uint64_t seed = 1;
};

void print(std::uint64_t seed, const std::string& name, const Outcome& outcome) {
  std::printf(
      "seed %llu, %s: %zu of %zu views placed, %zu wrong, %zu missed (%zu in a group apart); "
      "largest mean "
      "displacement %.4g (%.3f spacings), %.1f s\n",
      static_cast<unsigned long long>(seed), name.c_str(), outcome.placed, outcome.views,
      outcome.wrong, outcome.missed, outcome.beside, outcome.displacement,
      outcome.spacing > 0.0 ? outcome.displacement / outcome.spacing : 0.0, outcome.seconds);
  std::fflush(stdout);
}

int run_all(const Settings& settings) {
  std::vector<simulation::SimulationObject> objects;
  std::vector<std::string> names = {"owl"};
  Scene fixed;
  if (settings.simulate) {
    objects.push_back(simulation::built_in_simulation_object(0));
    for (const auto& path : settings.meshes) {
      objects.push_back(simulation::mesh_object(read_mesh(path).value()).value());
      names.push_back(path.substr(path.find_last_of('/') + 1));
    }
  } else if (!settings.boxes) {
    fixed = project_scene(settings.project, settings.truth);
  }
  Outcome total;
  for (int k = 0; k < settings.runs; ++k) {
    const std::uint64_t seed = settings.seed + static_cast<std::uint64_t>(k);
    Generator generator(seed);
    const Scene scene = settings.boxes      ? scene_of_box(generator)
                        : settings.simulate ? simulated_scene(objects, names, generator)
                                            : fixed;
    const Outcome outcome = run(scene, settings.poses == "random", settings.verbose, generator);
    print(seed, scene.name, outcome);
    total.views += outcome.views;
    total.placed += outcome.placed;
    total.wrong += outcome.wrong;
    total.missed += outcome.missed;
    total.beside += outcome.beside;
    total.seconds += outcome.seconds;
    total.displacement = std::max(total.displacement, outcome.displacement);
  }
  std::printf(
      "%d runs: %zu of %zu views placed, %zu wrong, %zu missed that share %.0f %% with "
      "another (%zu of them in a group apart); largest mean displacement %.4g; %.1f s of processor "
      "time per run\n",
      settings.runs, total.placed, total.views, total.wrong, total.missed, 100.0 * kMustOverlap,
      total.beside, total.displacement, total.seconds / settings.runs);
  return total.wrong > 0 ? 1 : 0;
}

}  // namespace
}  // namespace relief

int main(int argc, char** argv) {
  CLI::App app("Alignment without poses, over and over");
  relief::Settings settings;
  app.add_option("project", settings.project, "Scans whose poses are taken away");
  app.add_option("--truth", settings.truth, "Their true poses; default: those of the project");
  app.add_option("--poses", settings.poses, "What views start from")
      ->check(CLI::IsMember({"absent", "random"}));
  app.add_flag("--simulate", settings.simulate, "Simulated scans instead of a project");
  app.add_flag("--boxes", settings.boxes, "Simulated scans of cubes and boxes");
  app.add_option("--mesh", settings.meshes, "Meshes to simulate scans of, besides");
  app.add_option("--runs", settings.runs)->check(CLI::PositiveNumber);
  app.add_option("--seed", settings.seed, "Of the first run; the next ones count up");
  app.add_flag("-v,--verbose", settings.verbose, "Say why views are not placed");
  CLI11_PARSE(app, argc, argv);
  return relief::run_all(settings);
}
