#pragma once

#include <Eigen/Core>

#include "relief/scan/triangle_mesh.h"
#include "scan/simulation/objects/analytic_surface.h"

namespace relief::simulation {

/// The built-in object: a carved owl with its head turned, 97 mm tall, in millimetres, z up, its
/// breast towards -y. It is star-shaped (one radius for every direction from the origin), hence
/// closed and of genus 0, and smooth enough for continuous normals and almost everywhere continuous
/// curvature. Its relief spans the wavelengths that scanning is about: plumage of 5 to 6 mm,
/// grooves of the wings with barbs of 1.1 mm, pits and an engraved letter with strokes of 1.4 mm,
/// and on the back a chirp whose wavelength falls from 8 to 0.8 mm at constant slope.
AnalyticSurface built_in_object();

/// The distance from the origin to the built-in object's surface along a unit direction [mm].
double built_in_radius(const Eigen::Vector3d& direction);

/// The built-in object as a closed mesh: every vertex on the surface to rounding, `normals` exact.
/// Each edge of an icosahedron is split into `divisions` >= 1 parts and the result projected onto
/// the surface: 20 divisions^2 faces with edges of about 60 / divisions mm.
TriangleMesh built_in_truth_mesh(int divisions);

}  // namespace relief::simulation
