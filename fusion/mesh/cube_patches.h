#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "fusion/holes/plates/cotangent_laplacian.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/base/disjoint_sets.h"

namespace relief::fusion {

/// The edges of a closed mesh from either side: half-edge k of face f runs from its corner k to the
/// next one, and has the number 3 f + k.
class HalfEdges {
 public:
  explicit HalfEdges(const TriangleMesh& mesh);

  std::size_t size() const { return 3 * mesh_.faces.size(); }
  std::uint32_t from(std::size_t h) const { return mesh_.faces[h / 3][h % 3]; }
  static std::size_t next(std::size_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  std::size_t opposite(std::size_t h) const;

  /// Calls `visit` for all half-edges from a vertex.
  template <typename Visit>
  void visit_from(std::uint32_t vertex, const Visit& visit) const {
    around_.visit(vertex, [&](std::uint32_t face) {
      const auto& corners = mesh_.faces[face];
      visit(3 * std::size_t{face} + (corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2));
    });
  }

 private:
  const TriangleMesh& mesh_;
  FacesAround around_;
};

/// Faces of one cube that are joined by edges.
struct CubePatch {
  std::uint32_t first_face = 0;
  double area = 0.0;  ///< [unit^2]
  long faces = 0, border_edges = 0, inner_vertices = 0, borders = 0;

  /// Handles within the patch. Fans of faces at its border are vertices of their own, one to each
  /// edge of the border.
  long genus() const {
    const long twice_characteristic = 2 * inner_vertices + border_edges - faces;
    return (2 - borders - twice_characteristic / 2) / 2;
  }
};

/// The patches that cubes of one size cut a closed mesh into, each face by its centre.
class CubePatches {
 public:
  using Cell = std::array<std::int64_t, 3>;

  /// Cubes of `side` [unit] begin at the lower corner of the bounding box, or `shift` times their
  /// side before it along each axis.
  CubePatches(const TriangleMesh& mesh, double side, double shift = 0.0);

  Cell cell_of(std::size_t face) const;
  Eigen::AlignedBox3d cube(const Cell& cell) const;

  /// In the order of their first faces.
  const std::vector<CubePatch>& all() const { return patches_; }
  /// The faces of each patch that has handles, in ascending order.
  std::vector<std::vector<std::uint32_t>> faces_with_handles() const;

 private:
  CubePatch& patch_of(std::size_t face) { return patches_[patch_[face]]; }
  void join_faces();
  void measure_patches();
  void follow_borders();

  const TriangleMesh& mesh_;
  double side_;
  Eigen::Vector3d corner_;
  HalfEdges edges_;
  PagedArray<std::uint8_t> inner_;   // Half-edges between faces of one cube.
  PagedArray<std::uint32_t> patch_;  // Of each face, its place in `patches_`.
  std::vector<CubePatch> patches_;
};

}  // namespace relief::fusion
