#include "scan/simulation/defects/background_plate.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Geometry>

#include "relief/simulation/scan_defects.h"
#include "scan/base/parallel.h"
#include "scan/simulation/base/degrees.h"
#include "scan/simulation/base/option_check.h"
#include "scan/simulation/defects/scan_defects.h"

namespace relief::simulation {

namespace {

// The axis of the tilt in the image plane lies oblique, so that no image axis is special. A free
// choice of the scene, away from multiples of 45 degrees.
constexpr double kTiltAxisDeg = 30.0;

// Range of the first surface of `object` along a ray of the view; infinite when there is none.
double first_range(const SimulationObject& object, const RigidMotion& world_from_view,
                   const Ray& ray) {
  const auto hit =
      object.cast({world_from_view * ray.origin, world_from_view.linear() * ray.direction});
  return hit ? hit->range : std::numeric_limits<double>::infinity();
}

}  // namespace

Result<void> validate(const BackgroundPlate& plate) {
  return first_failure({require(plate.tilt_deg >= 0.0 && plate.tilt_deg <= 80.0,
                                "background tilt_deg", plate.tilt_deg, "in [0, 80]"),
                        require(std::isfinite(plate.distance) &&
                                    plate.distance * std::cos(radians(plate.tilt_deg)) > 0.5,
                                "background distance", plate.distance,
                                "more than 0.5 / cos(tilt) diameters, outside the object")});
}

Grid<unsigned char> add_background(RangeView& view, const SimulationObject& object,
                                   const BackgroundPlate& plate, double working_distance,
                                   double diameter, double max_incidence_deg) {
  Grid<unsigned char> seen(view.width(), view.height(), 0);
  const double axis_angle = radians(kTiltAxisDeg);
  const Eigen::AngleAxisd tilt(
      radians(plate.tilt_deg),
      Eigen::Vector3d(std::cos(axis_angle), std::sin(axis_angle), 0.0).normalized());
  const Eigen::Vector3d normal = tilt * -Eigen::Vector3d::UnitZ();
  const double level = normal.z() * (working_distance + plate.distance * diameter);
  const double least_cosine = std::max(0.0, std::cos(radians(max_incidence_deg)));
  parallel_for(view.range.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const int u = static_cast<int>(i) % view.width(), v = static_cast<int>(i) / view.width();
      const Ray ray = view.camera.ray(u, v);
      const double slope = normal.dot(ray.direction);
      if (!(-slope > least_cosine * ray.direction.norm())) continue;
      const double range = (level - normal.dot(ray.origin)) / slope;
      if (!(range > 0.0) || range >= first_range(object, view.world_from_view, ray)) continue;
      view.range[i] = range;
      view.normals[i] = normal.cast<float>();
      seen[i] = 1;
    }
  });
  return seen;
}

}  // namespace relief::simulation
