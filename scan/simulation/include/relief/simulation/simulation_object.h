#pragma once

#include <functional>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "relief/scan/projections.h"
#include "relief/scan/result.h"
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

/// A triangle mesh as the object of a simulation. Ranges and normals are those of the flat faces,
/// exactly: at facets larger than a sample spacing the scans show facets. The faces must be
/// oriented outwards; a view of a back face gives no sample. The object's sphere holds all
/// vertices, round the centre of their bounding box. kBadInput when the mesh has no area or a
/// vertex that is not finite.
Result<SimulationObject> mesh_object(TriangleMesh mesh, const std::string& unit = "mm");

/// The built-in object with its true mesh.
SimulationObject built_in_simulation_object(int mesh_divisions);

/// How the object's surface reflects light. Dark and glossy patches are fixed to the object, so all
/// views and sensors agree on where they are. The default is a white diffuse surface.
struct Reflectance {
  double dark_fraction = 0.0;    ///< Part of the surface that is dark, in [0, 1).
  double dark_albedo = 0.1;      ///< Diffuse albedo inside dark patches, in (0, 1]; 1 outside.
  double glossy_fraction = 0.0;  ///< Part of the surface that has a highlight, in [0, 1).
  /// Size of the patches: shortest wavelength of the field that makes them [diameters], > 0.
  double patch_size = 0.15;
  /// Angle between the normal and the half vector at which a highlight has fallen to 1/e [degrees],
  /// in (0, 90).
  double highlight_width_deg = 5.0;
  double highlight_strength = 2.0;  ///< Its light, that of a white diffuse surface being 1, >= 0.
};

/// A surface of which a tenth is dark and a tenth glossy.
Reflectance patchy_surface();

}  // namespace relief::simulation
