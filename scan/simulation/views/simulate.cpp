#include "relief/simulation/simulate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "scan/base/median.h"
#include "scan/base/parallel.h"
#include "scan/simulation/base/degrees.h"
#include "scan/simulation/base/option_check.h"
#include "scan/simulation/defects/background_plate.h"
#include "scan/simulation/objects/built_in_object.h"
#include "scan/simulation/sensors/sensor_errors.h"
#include "scan/simulation/sensors/sensor_scene.h"
#include "scan/simulation/sensors/sensors.h"
#include "scan/simulation/views/sensor_rays.h"
#include "scan/simulation/views/view_layout.h"

namespace relief::simulation {

namespace {

Result<void> validate(const SimulationOptions& o) {
  if (auto checked = validate(o.range_sensor); !checked) return checked;
  if (auto checked = validate(o.normal_sensor); !checked) return checked;
  if (auto checked = validate(o.reflectance); !checked) return checked;
  if (auto checked = validate(o.defects); !checked) return checked;
  return first_failure(
      {require(o.views >= 1 && o.views <= 9999, "views", o.views, "in [1, 9999]"),
       require(o.width >= 2, "width", o.width, "at least 2"),
       require(o.height >= 2, "height", o.height, "at least 2"),
       require(o.distance > 0.5 && std::isfinite(o.distance), "distance", o.distance,
               "more than 0.5 diameters, outside the object"),
       require_positive("fill", o.fill),
       require(o.max_incidence_deg > 0.0 && o.max_incidence_deg <= 90.0, "max_incidence_deg",
               o.max_incidence_deg, "in (0, 90]"),
       require_not_negative("pose_rotation_deg", o.pose_rotation_deg),
       require_not_negative("pose_translation", o.pose_translation),
       require(o.rays == SensorRays::kPinhole || o.defects.focal_factor == 1.0, "focal_factor",
               o.defects.focal_factor, "1 but for pinhole rays"),
       require(o.rays == SensorRays::kPinhole || o.defects.scale_factor == 1.0, "scale_factor",
               o.defects.scale_factor, "1 but for pinhole rays"),
       require(o.rays == SensorRays::kPinhole || o.defects.radial_distortion == 0.0,
               "radial_distortion", o.defects.radial_distortion, "0 but for pinhole rays"),
       require(o.mesh_divisions >= 0, "mesh_divisions", o.mesh_divisions, "0 or more")});
}

std::string view_name(int index) {
  std::string digits = std::to_string(index);
  return "v" + std::string(digits.size() < 3 ? 3 - digits.size() : 0, '0') + digits;
}

// Where all sensors stand; of given poses the median distance is the working distance.
struct Placement {
  std::vector<NamedPose> poses;
  double distance = 0.0;  // [unit]
};

Result<Placement> place_sensors(const SimulationObject& object, const SimulationOptions& options) {
  Placement placement;
  if (options.poses.empty()) {
    placement.distance = options.distance * 2.0 * object.radius;
    const auto poses =
        layout_poses(options.layout, options.views, object.centre, placement.distance);
    for (std::size_t i = 0; i < poses.size(); ++i)
      placement.poses.push_back(
          {view_name(static_cast<int>(i)), poses[i] * optical_from_sensor(options.rays)});
    return placement;
  }
  const bool inside = options.rays == SensorRays::kSpherical;
  std::vector<double> distances;
  for (const NamedPose& pose : options.poses) {
    distances.push_back((pose.world_from_view.translation() - object.centre).norm());
    if (!inside && !(distances.back() > object.radius))
      return Error{ErrorKind::kBadInput,
                   "the given pose of view " + pose.name +
                       " lies within the object's sphere; sensors stand outside of it"};
  }
  placement.poses = options.poses;
  placement.distance = median(std::move(distances));
  if (inside) placement.distance = std::max(placement.distance, object.radius);
  return placement;
}

// The focal length [pixels] at which the object's sphere fills the smaller side of the image; of a
// spherical sensor the pixels in a radian.
double framing_focal(const SimulationOptions& options, double relative_distance) {
  if (options.rays == SensorRays::kSpherical) return options.width / (2.0 * std::numbers::pi);
  const double half_angle = std::asin(0.5 / relative_distance);
  return options.fill * 0.5 * std::min(options.width, options.height) / std::tan(half_angle);
}

// What the sensors make of `scene.truth`.
RangeView measured(const SensorScene& scene, const SimulationOptions& options) {
  RangeView view = scene.truth;
  measure_normals(view, options.normal_sensor, scene);
  measure_range(view, options.range_sensor, scene);
  spoil_view(view, options.defects, scene);
  mistake_normals(view, options.defects.normal_mistake, scene.truth.world_from_view);
  return view;
}

RangeView scanned(SensorScene scene, const SimulationOptions& options) {
  scene.noise_half = options.defects.noise_half;
  if (!options.defects.background) return measured(scene, options);
  RangeView before_plate = scene.truth;
  const Grid<unsigned char> background =
      add_background(before_plate, scene.object, *options.defects.background, scene.distance,
                     scene.diameter, options.max_incidence_deg);
  scene.background = &background;
  return measured(scene.seeing(before_plate), options);
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
                    {options.seed, static_cast<std::uint64_t>(index) * 4 + 3}) *
      view.world_from_view;
}

Result<Simulation> simulate_views(const SimulationObject& object, const SimulationOptions& options,
                                  const Progress& progress) {
  if (const auto valid = validate(options); !valid) return valid.error();
  const auto placement = place_sensors(object, options);
  if (!placement) return placement.error();
  Simulation simulation;
  simulation.diameter = 2.0 * object.radius;
  simulation.distance = placement->distance;
  const double focal = framing_focal(options, simulation.distance / simulation.diameter);
  simulation.spacing = simulation.distance / focal;
  simulation.range_sigma =
      range_deviation(options.range_sensor, simulation.distance, simulation.spacing);
  simulation.scans.unit = simulation.truth.unit = object.unit;

  const Camera stated =
      sensor_camera(options.rays, options.width, options.height, focal, simulation.spacing);
  const Camera camera = true_camera(stated, options.defects);
  const auto paint_random = [&](SensorErrorKind kind) { return sensor_stream(options.seed, kind); };
  const PaintedSurface paint(options.reflectance, simulation.diameter, paint_random(kDarkPatches),
                             paint_random(kGlossyPatches));
  const int views = static_cast<int>(placement->poses.size());
  for (int index = 0; index < views; ++index) {
    if (!report_progress(progress, static_cast<double>(index) / views, "simulate views"))
      return Error{ErrorKind::kInterrupted, "simulation stopped"};
    const NamedPose& pose = placement->poses[static_cast<std::size_t>(index)];
    RangeView exact = exact_view(object, camera, pose.world_from_view, options.max_incidence_deg);
    exact.name = pose.name;
    RangeView scan = scanned({object, paint, exact, index, simulation.distance, simulation.spacing,
                              simulation.diameter, options.seed},
                             options);
    miscalibrate(scan, stated, options.defects, simulation.spacing);
    if (scan.sample_count() == 0)
      return Error{ErrorKind::kUnsolvable, "simulated view " + exact.name + " sees nothing"};
    set_pose(scan, index, object.centre, simulation.diameter, options);
    simulation.scans.views.push_back(std::move(scan));
    simulation.truth.views.push_back(std::move(exact));
  }
  simulation.mesh = object.mesh;
  report_progress(progress, 1.0, "simulate views");
  return simulation;
}

}  // namespace

SimulationObject built_in_simulation_object(int mesh_divisions) {
  const AnalyticSurface surface = built_in_object();
  SimulationObject object;
  object.radius = surface.bounding_radius;
  object.cast = [surface](const Ray& ray) -> std::optional<SurfaceHit> {
    const auto t = intersect(surface, ray);
    if (!t) return std::nullopt;
    return SurfaceHit{*t, unit_normal(surface, ray.at(*t))};
  };
  if (mesh_divisions > 0) object.mesh = built_in_truth_mesh(mesh_divisions);
  return object;
}

RangeView exact_view(const SimulationObject& object, const Camera& camera,
                     const RigidMotion& world_from_view, double max_incidence_deg) {
  RangeView view;
  view.camera = camera;
  view.world_from_view = world_from_view;
  view.pose = PoseKind::kKnown;
  view.range = Grid<double>(camera.width(), camera.height(), kNoSample);
  view.normals = Grid<Eigen::Vector3f>(camera.width(), camera.height(),
                                       Eigen::Vector3f::Constant(static_cast<float>(kNoSample)));
  const double least_cosine = std::max(0.0, std::cos(radians(max_incidence_deg)));
  const Eigen::Matrix3d view_from_world = world_from_view.linear().transpose();
  parallel_for(view.range.size(), 1024, [&](std::size_t begin, std::size_t end) {
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
                            const Context& context) {
  return run_in(context, [&] { return simulate_views(object, options, context.progress); });
}

Result<Simulation> simulate(const SimulationOptions& options, const Context& context) {
  if (const auto valid = validate(options); !valid) return valid.error();
  return run_in(context, [&] {
    return simulate(built_in_simulation_object(options.mesh_divisions), options, context);
  });
}

}  // namespace relief::simulation
