#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "fusion/holes/plates/cotangent_laplacian.h"
#include "relief/scan/page_allocator.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/memory_limit.h"

namespace relief::fusion {

/// A vertex of a plate.
struct PlateVertex {
  std::uint32_t vertex = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< Where it is held, or drawn to.
  /// How stiffly the surface goes on across it: 0, it is a hinge; 1, it keeps its slope.
  double stiffness = 1.0;
  /// How strongly a free vertex is drawn to its place [1/length^4]: a plate follows waves longer
  /// than about 2 pi / attraction^(1/4) and smooths shorter ones away. 0: not at all.
  double attraction = 0.0;
  /// The curvature normal 2 H n at rest, n inwards of a sphere [1/length]; zero: it rests plane.
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();
  /// How much that changes as the vertex moves, in the direction it moves [1/length^2]: a sphere
  /// that grows bends less.
  double growth = 0.0;
};

using PlateVertices = PagedVector<PlateVertex>;

/// A part of a mesh whose vertices take the places where a thin elastic plate would come to rest.
struct PlatePatch {
  PlateVertices free;
  PlateVertices held;  ///< All neighbours of free ones, and any others.
};

/// Free vertices of the largest plate that is worth its time and memory. The factors of 440,000
/// take 0.5 GB, those of four times as many 2.4 GB.
constexpr std::size_t kMostPlateVertices = 500000;

/// Places of the free vertices that minimise the sum of squared differences of the mean curvature
/// normals from those at rest, each over its area, and of squared moves
///
///   sum_v stiffness_v |(L x)_v - A_v k_v|^2 / A_v + sum_v attraction_v A_v |x_v - x_v^0|^2 (F7)
///
/// with the cotangent Laplacian L and the areas A of the mesh as given (Botsch and Kobbelt 2004).
/// It keeps planes plane and does not move vertices along them. Empty when the system is singular:
/// free vertices that nothing holds; and when `memory`, which may be null, cannot be kept.
std::vector<Eigen::Vector3d> solve_thin_plate(const TriangleMesh& mesh, const FacesAround& around,
                                              const PlatePatch& patch,
                                              MemoryLimit* memory = nullptr);

}  // namespace relief::fusion
