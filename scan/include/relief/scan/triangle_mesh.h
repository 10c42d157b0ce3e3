#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "relief/scan/grid.h"
#include "relief/scan/page_allocator.h"
#include "relief/scan/range_view.h"

namespace relief {

/// In TriangleMesh::source_views: no view measured the vertex.
inline constexpr std::uint16_t kNoSourceView = 65535;

/// An indexed triangle mesh. Faces wind counter-clockwise seen from outside. The attribute vectors
/// are empty or have one entry per vertex. Under a memory limit they lie as the pixels of a Grid
/// do.
struct TriangleMesh {
  using Face = std::array<std::uint32_t, 3>;

  PagedVector<Eigen::Vector3d> vertices;  ///< [unit]
  PagedVector<Face> faces;
  PagedVector<Eigen::Vector3f> normals;  ///< Unit vertex normals.
  PagedVector<float> quality;            ///< Expected error of the position [unit].
  PagedVector<std::uint16_t> views;      ///< How many views measured the vertex.
  /// The view with the largest weight at the vertex, by its index among those merged; or
  /// kNoSourceView.
  PagedVector<std::uint16_t> source_views;
  PagedVector<std::uint8_t> filled;  ///< 1: no view measured here, the surface was closed.
  PagedVector<Colour> colours;

  Eigen::Vector3d corner(std::size_t face, int k) const { return vertices[faces[face][k]]; }
};

/// Of all vertices; empty for a mesh without any.
Eigen::AlignedBox3d bounding_box(const TriangleMesh& mesh);

/// Unnormalised normal of a face: its length is twice the area.
Eigen::Vector3d face_cross(const TriangleMesh& mesh, std::size_t face);

double surface_area(const TriangleMesh& mesh);
/// Signed volume: positive for a closed mesh whose faces face outwards.
double enclosed_volume(const TriangleMesh& mesh);

/// Area-weighted unit vertex normals; zero where a vertex has no face with area.
PagedVector<Eigen::Vector3f> vertex_normals(const TriangleMesh& mesh);

/// The samples of a view as a mesh in the world frame, triangulated along its connected grid edges,
/// faces towards the sensor. Every sample is a vertex, in row order; `normals` are the measured
/// ones if any, `colours` its own.
TriangleMesh mesh_from_view(const RangeView& view);

}  // namespace relief
