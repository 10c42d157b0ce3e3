#include "fusion/mesh/small_handles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <vector>

#include "fusion/holes/plates/cotangent_laplacian.h"
#include "scan/base/disjoint_sets.h"
#include "scan/base/memory/paged_array.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

using Cell = std::array<std::int64_t, 3>;

PagedArray<std::uint8_t> all_vertices(const TriangleMesh& mesh) {
  PagedArray<std::uint8_t> all(mesh.vertices.size());
  std::fill(all.begin(), all.end(), std::uint8_t{1});
  return all;
}

// Half-edge k of face f runs from its corner k to the next one, and has the number 3 f + k.
class HalfEdges {
 public:
  explicit HalfEdges(const TriangleMesh& mesh)
      : mesh_(mesh), around_(mesh, all_vertices(mesh).span()) {}

  std::size_t size() const { return 3 * mesh_.faces.size(); }
  std::uint32_t from(std::size_t h) const { return mesh_.faces[h / 3][h % 3]; }
  static std::size_t next(std::size_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  std::size_t opposite(std::size_t h) const {
    std::size_t found = h;
    visit_from(from(next(h)), [&](std::size_t other) {
      if (from(next(other)) == from(h)) found = other;
    });
    return found;
  }
  // Calls `visit` for all half-edges from a vertex.
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

// Faces of one cube that are joined by edges.
struct CubePatch {
  std::size_t face = 0;  // Any of its faces.
  double area = 0.0;
  long faces = 0, border_edges = 0, inner_vertices = 0, borders = 0;

  // Fans of faces at its border are vertices of their own, one to each edge of the border.
  long genus() const {
    const long twice_characteristic = 2 * inner_vertices + border_edges - faces;
    return (2 - borders - twice_characteristic / 2) / 2;
  }
};

class CubePatches {
 public:
  CubePatches(const TriangleMesh& mesh, double side)
      : mesh_(mesh),
        side_(side),
        corner_(bounding_box(mesh).min()),
        edges_(mesh),
        sets_(mesh.faces.size()) {
    serial_for(edges_.size(), [&](std::size_t h) {
      if (is_inner(h)) sets_.join(face_of(h), face_of(edges_.opposite(h)));
    });
    serial_for(mesh.faces.size(), [&](std::size_t f) {
      CubePatch& patch = patch_of(f);
      patch.face = f;
      patch.area += 0.5 * face_cross(mesh, f).norm();
      ++patch.faces;
    });
    serial_for(mesh.vertices.size(), [&](std::size_t v) {
      std::size_t edges = 0, inner = 0, face = 0;
      edges_.visit_from(static_cast<std::uint32_t>(v), [&](std::size_t h) {
        ++edges;
        inner += is_inner(h) ? 1 : 0;
        face = h / 3;
      });
      if (edges > 0 && inner == edges) ++patch_of(face).inner_vertices;
    });
    follow_borders();
  }

  Cell cell_of(std::size_t face) const {
    const Eigen::Vector3d centre =
        (mesh_.corner(face, 0) + mesh_.corner(face, 1) + mesh_.corner(face, 2)) / 3.0;
    const Eigen::Vector3d at = ((centre - corner_) / side_).array().floor();
    return {static_cast<std::int64_t>(at.x()), static_cast<std::int64_t>(at.y()),
            static_cast<std::int64_t>(at.z())};
  }
  Eigen::AlignedBox3d cube(const Cell& cell) const {
    const Eigen::Vector3d low = corner_ + side_ * Eigen::Vector3d(static_cast<double>(cell[0]),
                                                                  static_cast<double>(cell[1]),
                                                                  static_cast<double>(cell[2]));
    return {low, low + Eigen::Vector3d::Constant(side_)};
  }
  const std::unordered_map<std::uint32_t, CubePatch>& all() const { return patches_; }

 private:
  static std::uint32_t face_of(std::size_t h) { return static_cast<std::uint32_t>(h / 3); }
  bool is_inner(std::size_t h) const { return cell_of(h / 3) == cell_of(edges_.opposite(h) / 3); }
  CubePatch& patch_of(std::size_t face) {
    return patches_[sets_.find(static_cast<std::uint32_t>(face))];
  }

  void follow_borders() {
    PagedArray<std::uint8_t> followed(edges_.size());
    serial_for(edges_.size(), [&](std::size_t start) {
      if (followed[start] || is_inner(start)) return;
      CubePatch& patch = patch_of(start / 3);
      ++patch.borders;
      for (std::size_t h = start; !followed[h];) {
        followed[h] = 1;
        ++patch.border_edges;
        h = HalfEdges::next(h);
        while (is_inner(h)) h = HalfEdges::next(edges_.opposite(h));
      }
    });
  }

  const TriangleMesh& mesh_;
  double side_;
  Eigen::Vector3d corner_;
  HalfEdges edges_;
  DisjointSets sets_;
  std::unordered_map<std::uint32_t, CubePatch> patches_;  // By their first faces.
};

// Takes the cubes that touch `cell`, and those that touch these, out of `handles`.
std::vector<Cell> take_region(const Cell& cell, std::map<Cell, long>& handles, long& in_region) {
  std::vector<Cell> region = {cell};
  in_region = handles.at(cell);
  handles.erase(cell);
  for (std::size_t i = 0; i < region.size(); ++i)
    for (int k = 0; k < 27; ++k) {
      const auto [x, y, z] = region[i];
      const Cell beside = {x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1};
      const auto found = handles.find(beside);
      if (found == handles.end()) continue;
      in_region += found->second;
      handles.erase(found);
      region.push_back(beside);
    }
  return region;
}

}  // namespace

SmallHandles find_small_handles(const TriangleMesh& mesh, double side) {
  SmallHandles result;
  if (mesh.faces.empty()) return result;
  const CubePatches patches(mesh, side);
  std::map<Cell, long> handles;
  double area = 0.0, area_of_all = 0.0;
  for (const auto& [unused, patch] : patches.all()) {
    area_of_all += patch.area;
    const long genus = patch.genus();
    if (genus <= 0) continue;
    result.count += static_cast<std::size_t>(genus);
    area += patch.area;
    handles[patches.cell_of(patch.face)] += genus;
  }
  if (area_of_all > 0.0) result.area_fraction = area / area_of_all;
  while (!handles.empty()) {
    long in_region = 0;
    const auto region = take_region(handles.begin()->first, handles, in_region);
    if (static_cast<std::size_t>(in_region) <= result.in_region) continue;
    result.in_region = static_cast<std::size_t>(in_region);
    result.region.setEmpty();
    for (const Cell& cell : region) result.region.extend(patches.cube(cell));
  }
  return result;
}

}  // namespace relief::fusion
