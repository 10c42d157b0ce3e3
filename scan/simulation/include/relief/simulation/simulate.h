#pragma once

#include <cstdint>
#include <vector>

#include "relief/scan/camera.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "relief/scan/scan_project.h"
#include "relief/scan/triangle_mesh.h"
#include "relief/simulation/normal_sensors.h"
#include "relief/simulation/range_sensors.h"
#include "relief/simulation/scan_defects.h"
#include "relief/simulation/simulation_object.h"

namespace relief::simulation {

/// How the rays of a simulated sensor run. View frame: x right, y down, z forward; the range of a
/// sample is its depth z.
enum class SensorRays {
  kPinhole,       ///< Through one point.
  kOrthographic,  ///< Parallel.
  kLine,  ///< Of a line scanner that moves along x: parallel from column to column, and within a
          ///< column through one point (the linear pushbroom camera of Gupta and Hartley 1997).
  kSpherical,  ///< Of a scanner that turns round its axis: whole turns of azimuth, and elevations
               ///< as far up and down as the rows allow at the same step. Here z of the view frame
               ///< is the axis and points up, x is forward, and the range is the distance.
};

/// Where the sensor stands round the object.
enum class ViewLayout {
  kTurntable,  ///< A ring round z, its elevations alternately 20 and -10 degrees, and of every six
               ///< views one at 60 degrees above and one at 60 degrees below. The first is at -y.
  kSphere,     ///< Evenly over the sphere, along a Fibonacci spiral from top to bottom.
};

/// The defaults are choices that most figures of docs/results.md are measured with.
struct SimulationOptions {
  int views = 12;                 ///< >= 1.
  int width = 512, height = 512;  ///< Pixels of every view, >= 2.
  SensorRays rays = SensorRays::kPinhole;
  ViewLayout layout = ViewLayout::kTurntable;
  /// From the sensor to the object's centre [diameters of its sphere], > 0.5.
  double distance = 4.0;
  /// Poses and names of the views, in place of `views`, `layout` and `distance`; the working
  /// distance is the median of theirs. Spherical sensors may stand inside of the object, and have
  /// its radius as the least working distance. Empty: `layout` rules.
  std::vector<NamedPose> poses;
  /// Part of the smaller image side that the object's sphere fills at the working distance, > 0.
  double fill = 0.95;
  /// Steepest angle between the viewing ray and the surface normal that still gives a sample
  /// [degrees], in (0, 90]. Real scanners lose the surface well before the silhouette.
  double max_incidence_deg = 80.0;

  RangeSensor range_sensor = WhiteRangeSensor{};
  NormalSensor normal_sensor = WhiteNormalSensor{};
  Reflectance reflectance;  ///< Of the object; the white sensors do not look at it.
  ScanDefects defects;      ///< On top of the sensors' errors; none by default.

  /// What the scans tell of their poses. kGuess: the first one exact and known, the others off by
  /// the two amounts below; kKnown: all exact; kAbsent: none given.
  PoseKind pose = PoseKind::kGuess;
  double pose_rotation_deg =
      2.0;  ///< Angle of the error, about an axis through the object's centre.
  double pose_translation = 0.01;  ///< Length of the error [diameters].

  /// Divisions of the built-in object's true mesh (built_in_truth_mesh): 256 gives 1.3 million
  /// faces with edges of about 0.2 mm. 0: no mesh.
  int mesh_divisions = 256;
  std::uint64_t seed = 1;  ///< Of all errors. Equal options give equal bytes.
};

/// Scans with their truth: the same views and names in both projects. Each sample of a scan is a
/// sample of the truth, but for those of a background plate, which is no part of the truth; the
/// truth has more where a sensor lost the surface.
struct Simulation {
  ScanProject scans;      ///< As the sensors give them, with pose errors.
  ScanProject truth;      ///< Exact range, normals and poses; all poses kKnown.
  TriangleMesh mesh;      ///< The true surface in the world frame.
  double diameter = 0.0;  ///< Of the object's sphere [unit].
  double distance = 0.0;  ///< Working distance: from the sensor to the object's centre [unit].
  double spacing = 0.0;   ///< The nominal sample spacing: one pixel at the object's centre [unit].
  double range_sigma = 0.0;  ///< Standard deviation of the range noise at the centre [unit].
};

/// Scans of `object`. kBadInput names an option out of its range; kUnsolvable when a view sees
/// nothing; kInterrupted when `progress` asks to stop.
Result<Simulation> simulate(const SimulationObject& object, const SimulationOptions& options,
                            const Context& context = {});

/// Scans of the built-in object.
Result<Simulation> simulate(const SimulationOptions& options, const Context& context = {});

/// The exact view of an object: range and true normals, without the samples steeper than
/// `max_incidence_deg`.
RangeView exact_view(const SimulationObject& object, const Camera& camera,
                     const RigidMotion& world_from_view, double max_incidence_deg);

}  // namespace relief::simulation
