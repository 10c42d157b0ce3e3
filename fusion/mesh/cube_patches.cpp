#include "fusion/mesh/cube_patches.h"

#include <algorithm>
#include <unordered_map>

#include "scan/base/memory/paged_array.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

PagedArray<std::uint8_t> all_vertices(const TriangleMesh& mesh) {
  PagedArray<std::uint8_t> all(mesh.vertices.size());
  std::fill(all.begin(), all.end(), std::uint8_t{1});
  return all;
}

}  // namespace

HalfEdges::HalfEdges(const TriangleMesh& mesh)
    : mesh_(mesh), around_(mesh, all_vertices(mesh).span()) {}

std::size_t HalfEdges::opposite(std::size_t h) const {
  std::size_t found = h;
  visit_from(from(next(h)), [&](std::size_t other) {
    if (from(next(other)) == from(h)) found = other;
  });
  return found;
}

CubePatches::CubePatches(const TriangleMesh& mesh, double side, double shift)
    : mesh_(mesh),
      side_(side),
      corner_(bounding_box(mesh).min() - Eigen::Vector3d::Constant(shift * side)),
      edges_(mesh),
      inner_(edges_.size()),
      patch_(mesh.faces.size()) {
  join_faces();
  measure_patches();
  follow_borders();
}

CubePatches::Cell CubePatches::cell_of(std::size_t face) const {
  const Eigen::Vector3d centre =
      (mesh_.corner(face, 0) + mesh_.corner(face, 1) + mesh_.corner(face, 2)) / 3.0;
  const Eigen::Vector3d at = ((centre - corner_) / side_).array().floor();
  return {static_cast<std::int64_t>(at.x()), static_cast<std::int64_t>(at.y()),
          static_cast<std::int64_t>(at.z())};
}

Eigen::AlignedBox3d CubePatches::cube(const Cell& cell) const {
  const Eigen::Vector3d low =
      corner_ + side_ * Eigen::Vector3d(static_cast<double>(cell[0]), static_cast<double>(cell[1]),
                                        static_cast<double>(cell[2]));
  return {low, low + Eigen::Vector3d::Constant(side_)};
}

std::vector<std::vector<std::uint32_t>> CubePatches::faces_with_handles() const {
  std::vector<std::vector<std::uint32_t>> faces;
  std::unordered_map<std::uint32_t, std::size_t> place;  // By the number of the patch.
  for (std::uint32_t p = 0; p < patches_.size(); ++p)
    if (patches_[p].genus() > 0) {
      place.emplace(p, faces.size());
      faces.emplace_back();
    }
  serial_for(mesh_.faces.size(), [&](std::size_t f) {
    if (const auto found = place.find(patch_[f]); found != place.end())
      faces[found->second].push_back(static_cast<std::uint32_t>(f));
  });
  return faces;
}

void CubePatches::join_faces() {
  DisjointSets sets(mesh_.faces.size());
  serial_for(edges_.size(), [&](std::size_t h) {
    if (edges_.from(h) > edges_.from(HalfEdges::next(h))) return;  // Its opposite comes by.
    const std::size_t beyond = edges_.opposite(h);
    if (cell_of(h / 3) != cell_of(beyond / 3)) return;
    inner_[h] = inner_[beyond] = 1;
    sets.join(static_cast<std::uint32_t>(h / 3), static_cast<std::uint32_t>(beyond / 3));
  });
  serial_for(mesh_.faces.size(), [&](std::size_t i) {
    const auto f = static_cast<std::uint32_t>(i);
    const std::uint32_t first = sets.find(f);  // Not after f.
    if (first == f) {
      patch_[f] = static_cast<std::uint32_t>(patches_.size());
      patches_.push_back({.first_face = f});
    } else {
      patch_[f] = patch_[first];
    }
  });
}

void CubePatches::measure_patches() {
  serial_for(mesh_.faces.size(), [&](std::size_t f) {
    CubePatch& patch = patch_of(f);
    patch.area += 0.5 * face_cross(mesh_, f).norm();
    ++patch.faces;
  });
  serial_for(mesh_.vertices.size(), [&](std::size_t v) {
    std::size_t edges = 0, inner = 0, face = 0;
    edges_.visit_from(static_cast<std::uint32_t>(v), [&](std::size_t h) {
      ++edges;
      inner += inner_[h];
      face = h / 3;
    });
    if (edges > 0 && inner == edges) ++patch_of(face).inner_vertices;
  });
}

void CubePatches::follow_borders() {
  PagedArray<std::uint8_t> followed(edges_.size());
  serial_for(edges_.size(), [&](std::size_t start) {
    if (followed[start] || inner_[start]) return;
    CubePatch& patch = patch_of(start / 3);
    ++patch.borders;
    for (std::size_t h = start; !followed[h];) {
      followed[h] = 1;
      ++patch.border_edges;
      h = HalfEdges::next(h);
      while (inner_[h]) h = HalfEdges::next(edges_.opposite(h));
    }
  });
}

}  // namespace relief::fusion
