#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "scan/progress.h"
#include "scan/result.h"
#include "scan/scan_project.h"
#include "scan/simulation/view_layout.h"
#include "scan/triangle_mesh.h"

namespace relief {

/// Where a ray first meets an object.
struct SurfaceHit {
  double range = 0.0;                                ///< t of equation (1).
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< Unit, outward.
};

/// What is scanned.
struct SimulationObject {
  std::string unit = "mm";
  /// Where a ray of the world frame enters the object, if it does. Called from several threads.
  std::function<std::optional<SurfaceHit>(const Ray&)> cast;
  /// A sphere that holds the object [unit]: the cameras look at its centre and its image fills
  /// theirs.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0;
  TriangleMesh mesh;  ///< The true surface, to evaluate against; passed through.
};

struct SimulationOptions {
  int views = 12;                 ///< >= 1.
  int width = 512, height = 512;  ///< Pixels of every view, >= 2.
  ViewLayout layout = ViewLayout::kTurntable;
  double distance =
      4.0;             ///< From the camera to the object's centre [diameters of its sphere], > 0.5.
  double fill = 0.95;  ///< Part of the smaller image side that the object's sphere fills, > 0.
  /// Steepest angle between the viewing ray and the surface normal that still gives a sample
  /// [degrees], in (0, 90]. Real scanners lose the surface well before the silhouette.
  double max_incidence_deg = 80.0;

  double range_noise = 0.3;  ///< Standard deviation along the ray [sample spacings], >= 0.
  double normal_noise_deg =
      1.5;                       ///< White noise: standard deviation about each tangent axis, >= 0.
  double normal_bias_deg = 4.0;  ///< Smooth error: RMS of its angle over each view, >= 0.
  double normal_bias_wavelength = 0.5;  ///< Its shortest wave length [diameters], > 0.

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
  int threads = 0;         ///< 0: one per core; no effect on the result.
};

/// Scans with their truth: the same views, names and samples in both projects.
struct Simulation {
  ScanProject
      scans;  ///< As a sensor gives them: noisy range, biased and noisy normals, pose errors.
  ScanProject truth;      ///< Exact range, normals and poses; all poses kKnown.
  TriangleMesh mesh;      ///< The true surface in the world frame.
  double diameter = 0.0;  ///< Of the object's sphere [unit].
  double spacing = 0.0;   ///< The nominal sample spacing: one pixel at the object's centre [unit].
  double range_sigma = 0.0;  ///< Standard deviation of the range noise along the ray [unit].
};

/// The built-in object with its true mesh.
SimulationObject built_in_simulation_object(int mesh_divisions, int threads = 0);

/// Scans of `object` by pinhole cameras. kBadInput names an option out of its range; kUnsolvable
/// when a view sees nothing; kInterrupted when `progress` asks to stop.
Result<Simulation> simulate(const SimulationObject& object, const SimulationOptions& options,
                            const Progress& progress = {});

/// Scans of the built-in object.
Result<Simulation> simulate(const SimulationOptions& options, const Progress& progress = {});

/// The exact view of an object: range and true normals, without the samples steeper than
/// `max_incidence_deg`.
RangeView exact_view(const SimulationObject& object, const Camera& camera,
                     const RigidMotion& world_from_view, double max_incidence_deg, int threads = 0);

}  // namespace relief
