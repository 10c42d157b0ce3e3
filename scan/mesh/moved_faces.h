#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/page_allocator.h"
#include "relief/scan/triangle_mesh.h"

namespace relief {

/// Faces, in ascending order, that a move of vertices to `places` has made invalid: those that
/// intersect others and those without any width left. Looks at faces with a vertex in `moved` and
/// at what is near them only. `reach` is about the length of an edge [unit].
std::vector<std::uint32_t> invalid_faces(const TriangleMesh& mesh,
                                         const PagedVector<Eigen::Vector3d>& places,
                                         std::span<const std::uint8_t> moved, double reach);

/// The faces with a vertex that is marked; in ascending order.
PagedVector<std::uint32_t> faces_at(const TriangleMesh& mesh, std::span<const std::uint8_t> marked);

/// Those of `faces`, and of what is near them or of all where they are many, that intersect others;
/// in ascending order.
std::vector<std::uint32_t> intersecting_faces(const TriangleMesh& mesh,
                                              PagedVector<std::uint32_t> faces, double reach);

}  // namespace relief
