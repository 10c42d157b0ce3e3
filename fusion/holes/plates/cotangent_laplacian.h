#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/paged_array.h"

namespace relief::fusion {

/// The faces at each vertex of a part of a mesh.
class FacesAround {
 public:
  /// Of the vertices with `wanted` set.
  FacesAround(const TriangleMesh& mesh, std::span<const std::uint8_t> wanted);

  /// Calls `visit(face)` for the faces at a vertex, in ascending order; none for unwanted vertices.
  template <typename Visit>
  void visit(std::uint32_t vertex, const Visit& visit) const {
    for (std::size_t k = first_[vertex]; k < first_[vertex + 1]; ++k) visit(faces_[k]);
  }

 private:
  PagedArray<std::uint32_t> first_, faces_;
};

/// Edges from the nearest of `start` to each vertex that is no farther than `most` edges, across
/// vertices that `around` has the faces of.
std::unordered_map<std::uint32_t, int> edges_from(std::vector<std::uint32_t> start, int most,
                                                  const TriangleMesh& mesh,
                                                  const FacesAround& around);

/// Cotangents of a face's three angles, and its area.
struct FaceShape {
  std::array<double, 3> cotangents;
  double area = 0.0;  ///< [unit^2]
};

/// Slivers count as a little thicker than they are.
FaceShape shape_of(const TriangleMesh& mesh, std::uint32_t face);

/// A third of the area of the faces at a vertex [unit^2].
double area_at(const TriangleMesh& mesh, const FacesAround& around, std::uint32_t vertex);

/// Calls `visit(other, weight)` for the neighbours of a vertex, twice for each, with half the
/// cotangent of the angle across the edge: the row of the Laplacian L has the sums of these, and
/// minus the sum of all at the vertex itself.
template <typename Visit>
void visit_cotangents(const TriangleMesh& mesh, const FacesAround& around, std::uint32_t vertex,
                      const Visit& visit) {
  around.visit(vertex, [&](std::uint32_t face) {
    const FaceShape shape = shape_of(mesh, face);
    const auto& corners = mesh.faces[face];
    const std::size_t own = corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2;
    for (const std::size_t k : {(own + 1) % 3, (own + 2) % 3})
      visit(corners[k], 0.5 * shape.cotangents[3 - own - k]);
  });
}

}  // namespace relief::fusion
