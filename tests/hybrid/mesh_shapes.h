#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "relief/hybrid/polish_mesh.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::testing {

/// A flat grid of size x size unit squares in the plane z = 0, each split into two faces.
TriangleMesh plane_mesh(int size);

/// A closed box round the origin, its faces split into squares of about `spacing`.
TriangleMesh box_mesh(const Eigen::Vector3d& size, double spacing);

/// A closed torus round the z axis.
TriangleMesh torus_mesh(double radius, double tube, int around, int across);
double torus_distance(const Eigen::Vector3d& point, double radius, double tube);

TriangleMesh sphere_mesh(double radius, int divisions);

/// The vertex normals of `exact` as if views had measured them with an error of `sigma` [rad].
hybrid::MeshNormals exact_normals(const TriangleMesh& exact, double spacing, double sigma);

/// Moves each vertex by Gaussian noise of `sigma` along its normal, and says so in `quality`.
void add_vertex_noise(TriangleMesh& mesh, double sigma, std::uint64_t seed);

}  // namespace relief::testing
