#pragma once

#include <functional>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "relief/scan/ray.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::simulation {

/// Where a ray first meets an object.
struct SurfaceHit {
  double range = 0.0;                                ///< t of equation (V1).
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

/// Whether nothing of the object lies between `from`, outside it, and `point` on its surface (both
/// in the world). Surface within 1e-6 of the distance before the point counts as the point itself.
bool in_sight(const SimulationObject& object, const Eigen::Vector3d& from,
              const Eigen::Vector3d& point);

}  // namespace relief::simulation
