#include "scan/simulation/simulate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <utility>

#include "scan/parallel.h"
#include "scan/simulation/built_in_object.h"
#include "scan/simulation/sensor_errors.h"

namespace relief {

namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

Result<void> require(bool holds, const char* field, double value, const char* constraint) {
  if (holds) return {};
  std::ostringstream message;
  message << "simulation option " << field << " is " << value << "; it must be " << constraint;
  return Error{ErrorKind::kBadInput, message.str()};
}

Result<void> validate(const SimulationOptions& o) {
  const auto least_zero = [](double value) { return std::isfinite(value) && value >= 0.0; };
  for (const Result<void>& check :
       {require(o.views >= 1 && o.views <= 9999, "views", o.views, "in [1, 9999]"),
        require(o.width >= 2, "width", o.width, "at least 2"),
        require(o.height >= 2, "height", o.height, "at least 2"),
        require(o.distance > 0.5 && std::isfinite(o.distance), "distance", o.distance,
                "more than 0.5 diameters, outside the object"),
        require(o.fill > 0.0 && std::isfinite(o.fill), "fill", o.fill, "positive"),
        require(o.max_incidence_deg > 0.0 && o.max_incidence_deg <= 90.0, "max_incidence_deg",
                o.max_incidence_deg, "in (0, 90]"),
        require(least_zero(o.range_noise), "range_noise", o.range_noise, "0 or more"),
        require(least_zero(o.normal_noise_deg), "normal_noise_deg", o.normal_noise_deg,
                "0 or more"),
        require(least_zero(o.normal_bias_deg), "normal_bias_deg", o.normal_bias_deg, "0 or more"),
        require(o.normal_bias_wavelength > 0.0, "normal_bias_wavelength", o.normal_bias_wavelength,
                "positive"),
        require(least_zero(o.pose_rotation_deg), "pose_rotation_deg", o.pose_rotation_deg,
                "0 or more"),
        require(least_zero(o.pose_translation), "pose_translation", o.pose_translation,
                "0 or more"),
        require(o.mesh_divisions >= 0, "mesh_divisions", o.mesh_divisions, "0 or more")})
    if (!check) return check;
  return {};
}

// A camera whose image of the object's sphere fills the smaller side of the image.
Camera framing_camera(const SimulationOptions& options) {
  const double half_angle = std::asin(0.5 / options.distance);
  const double focal =
      options.fill * 0.5 * std::min(options.width, options.height) / std::tan(half_angle);
  return Camera::pinhole(options.width, options.height,
                         {focal, focal, 0.5 * (options.width - 1), 0.5 * (options.height - 1)});
}

std::string view_name(int index) {
  std::string digits = std::to_string(index);
  return "v" + std::string(digits.size() < 3 ? 3 - digits.size() : 0, '0') + digits;
}

// The random streams of one view.
enum Stream : std::uint64_t { kRangeNoise, kNormalNoise, kNormalBias, kPose, kStreams };

RandomStream stream_of(const SimulationOptions& options, int view, Stream stream) {
  return {options.seed, static_cast<std::uint64_t>(view) * kStreams + stream};
}

// The bias belongs to the surface, the noise to the single sample: bias first.
RangeView scanned(RangeView view, int index, const Simulation& simulation,
                  const SimulationOptions& options) {
  add_normal_bias(view, radians(options.normal_bias_deg),
                  options.normal_bias_wavelength * simulation.diameter,
                  stream_of(options, index, kNormalBias));
  add_normal_noise(view, radians(options.normal_noise_deg),
                   stream_of(options, index, kNormalNoise));
  add_range_noise(view, simulation.range_sigma, stream_of(options, index, kRangeNoise));
  return view;
}

void set_pose(RangeView& view, int index, const Eigen::Vector3d& centre, double diameter,
              const SimulationOptions& options) {
  view.pose = options.pose;
  if (options.pose == PoseKind::kAbsent) view.world_from_view = RigidMotion::Identity();
  if (options.pose != PoseKind::kGuess) return;
  if (index == 0) {
    view.pose = PoseKind::kKnown;
    return;
  }
  view.world_from_view =
      random_motion(radians(options.pose_rotation_deg), options.pose_translation * diameter, centre,
                    stream_of(options, index, kPose)) *
      view.world_from_view;
}

}  // namespace

SimulationObject built_in_simulation_object(int mesh_divisions, int threads) {
  const AnalyticSurface surface = built_in_object();
  SimulationObject object;
  object.radius = surface.bounding_radius;
  object.cast = [surface](const Ray& ray) -> std::optional<SurfaceHit> {
    const auto t = intersect(surface, ray);
    if (!t) return std::nullopt;
    return SurfaceHit{*t, unit_normal(surface, ray.at(*t))};
  };
  if (mesh_divisions > 0) object.mesh = built_in_truth_mesh(mesh_divisions, threads);
  return object;
}

RangeView exact_view(const SimulationObject& object, const Camera& camera,
                     const RigidMotion& world_from_view, double max_incidence_deg, int threads) {
  RangeView view;
  view.camera = camera;
  view.world_from_view = world_from_view;
  view.pose = PoseKind::kKnown;
  view.range = Grid<double>(camera.width(), camera.height(), kNoSample);
  view.normals = Grid<Eigen::Vector3f>(camera.width(), camera.height(),
                                       Eigen::Vector3f::Constant(static_cast<float>(kNoSample)));
  const double least_cosine = std::max(0.0, std::cos(radians(max_incidence_deg)));
  const Eigen::Matrix3d view_from_world = world_from_view.linear().transpose();
  parallel_for(view.range.size(), 1024, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const int u = static_cast<int>(i) % camera.width(), v = static_cast<int>(i) / camera.width();
      const Ray ray = camera.ray(u, v);
      const auto hit =
          object.cast({world_from_view * ray.origin, world_from_view.linear() * ray.direction});
      if (!hit) continue;
      const Eigen::Vector3d normal = view_from_world * hit->normal;
      if (!(-normal.dot(ray.direction) > least_cosine * ray.direction.norm())) continue;
      view.range[i] = hit->range;
      view.normals[i] = normal.cast<float>();
    }
  });
  return view;
}

Result<Simulation> simulate(const SimulationObject& object, const SimulationOptions& options,
                            const Progress& progress) {
  if (const auto valid = validate(options); !valid) return valid.error();
  const Camera camera = framing_camera(options);
  Simulation simulation;
  simulation.diameter = 2.0 * object.radius;
  const double distance = options.distance * simulation.diameter;
  simulation.spacing = distance / camera.intrinsics().fx;
  simulation.range_sigma = options.range_noise * simulation.spacing;
  simulation.scans.unit = simulation.truth.unit = object.unit;

  const auto poses = layout_poses(options.layout, options.views, object.centre, distance);
  for (int index = 0; index < options.views; ++index) {
    if (!report_progress(progress, static_cast<double>(index) / options.views, "simulate views"))
      return Error{ErrorKind::kInterrupted, "simulation stopped"};
    RangeView exact = exact_view(object, camera, poses[static_cast<std::size_t>(index)],
                                 options.max_incidence_deg, options.threads);
    exact.name = view_name(index);
    if (exact.sample_count() == 0)
      return Error{ErrorKind::kUnsolvable, "simulated view " + exact.name + " sees nothing"};
    RangeView scan = scanned(exact, index, simulation, options);
    set_pose(scan, index, object.centre, simulation.diameter, options);
    simulation.scans.views.push_back(std::move(scan));
    simulation.truth.views.push_back(std::move(exact));
  }
  simulation.mesh = object.mesh;
  report_progress(progress, 1.0, "simulate views");
  return simulation;
}

Result<Simulation> simulate(const SimulationOptions& options, const Progress& progress) {
  if (const auto valid = validate(options); !valid) return valid.error();
  return simulate(built_in_simulation_object(options.mesh_divisions, options.threads), options,
                  progress);
}

}  // namespace relief
