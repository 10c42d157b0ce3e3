#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "fusion/holes/fair_regions.h"
#include "fusion/holes/plates/cotangent_laplacian.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

/// Twice the mean curvature at some vertices [1/length], positive on a sphere. Where `known` is set
/// it is that of the mesh, averaged over four edges of length `edge` [unit]; elsewhere it is
/// harmonic in between. Zero throughout when nothing is known.
Eigen::VectorXd continued_curvature(const TriangleMesh& mesh, const FacesAround& around,
                                    const std::vector<std::uint32_t>& vertices,
                                    const std::vector<std::uint8_t>& known, double edge);

/// Lets the vertices and the border of a region rest with such a curvature about the normals that
/// the mesh has, in this order.
void bend_to(const TriangleMesh& mesh, const FacesAround& around, const Eigen::VectorXd& curvature,
             FairRegion& region);

/// Lets a curved region rest, far from what was measured, as the mesh has it, and near by as its
/// surroundings do. `voxel`: length of the edges of the mesh [unit].
void set_rest_curvature(const MeshRings& of, double voxel, FairRegion& region);

}  // namespace relief::fusion
