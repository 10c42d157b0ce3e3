#include "fusion/holes/side_normals.h"

#include <algorithm>

#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"
#include "scan/mesh/moved_faces.h"

namespace relief::fusion {

namespace {

bool is_measured(const TriangleMesh& mesh, const TriangleMesh::Face& face) {
  return std::none_of(face.begin(), face.end(), [&](std::uint32_t v) { return mesh.filled[v]; });
}

// What was filled, and what was measured and has no filled vertex beside it in some face: sorted.
PagedVector<std::uint32_t> vertices_of_a_side(const TriangleMesh& mesh,
                                              std::span<const std::uint32_t> faces) {
  PagedVector<std::uint32_t> vertices;
  serial_for(faces.size(), [&](std::size_t i) {
    const auto& face = mesh.faces[faces[i]];
    const bool measured = is_measured(mesh, face);
    for (const std::uint32_t v : face)
      if (mesh.filled[v] || measured) vertices.push_back(v);
  });
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

}  // namespace

// One pass of averaging for each ring of kReach. The area grows with their number: with half of it
// noise and ragged borders tilt the mean 1.4 times as far, with twice it reaches past edges.
SideNormals::SideNormals(const TriangleMesh& mesh, std::span<const std::uint8_t> wanted)
    : mesh_(mesh) {
  const auto faces = faces_at(mesh, wanted);
  vertices_ = vertices_of_a_side(mesh, faces);
  normals_ = paged_filled(vertices_.size(), Eigen::Vector3d(Eigen::Vector3d::Zero()));
  corners_.reserve(faces.size());
  serial_for(faces.size(), [&](std::size_t i) {
    const auto& face = mesh.faces[faces[i]];
    const Eigen::Vector3d cross = face_cross(mesh, faces[i]);
    const bool measured = is_measured(mesh, face);
    std::array<std::uint32_t, 3>& corners = corners_.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = place_of(face[k]);
      if (mesh.filled[face[k]] || measured) normals_[corners[k]] += cross;
    }
  });
  for (int ring = 0; ring < kReach; ++ring) average();
}

std::uint32_t SideNormals::place_of(std::uint32_t vertex) const {
  const auto found = std::lower_bound(vertices_.begin(), vertices_.end(), vertex);
  return found == vertices_.end() || *found != vertex
             ? kUnknown
             : static_cast<std::uint32_t>(found - vertices_.begin());
}

Eigen::Vector3d SideNormals::at(std::uint32_t vertex) const {
  const std::uint32_t place = place_of(vertex);
  return place == kUnknown ? Eigen::Vector3d::Zero() : normals_[place].normalized();
}

double SideNormals::cosine(std::uint32_t vertex, const FacesAround& around) const {
  const Eigen::Vector3d own = at(vertex);
  if (own.isZero()) return 1.0;
  Eigen::Vector3d other = Eigen::Vector3d::Zero();
  around.visit(vertex, [&](std::uint32_t f) {
    for (const std::uint32_t v : mesh_.faces[f])
      if (mesh_.filled[v]) other += normals_[place_of(v)];
  });
  return other.normalized().dot(own);
}

void SideNormals::average() {
  auto sums = paged_copy(normals_);
  const auto same_side = [&](std::uint32_t v, std::uint32_t w) {
    return v != w && v != kUnknown && w != kUnknown &&
           mesh_.filled[vertices_[v]] == mesh_.filled[vertices_[w]];
  };
  serial_for(corners_.size(), [&](std::size_t f) {
    for (const std::uint32_t v : corners_[f])
      for (const std::uint32_t w : corners_[f])
        if (same_side(v, w)) sums[v] += normals_[w];
  });
  normals_ = std::move(sums);
}

}  // namespace relief::fusion
