#include "relief/scan/mesh_check.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <numeric>
#include <tuple>
#include <vector>

#include "scan/base/disjoint_sets.h"
#include "scan/base/parallel.h"

namespace relief {

namespace {

// One side of a face, as an undirected edge. `corner` is 3 face + k, where the side starts.
struct HalfEdge {
  std::uint32_t low, high, corner;

  bool same_edge(const HalfEdge& other) const { return low == other.low && high == other.high; }
  bool operator<(const HalfEdge& other) const {
    return std::tie(low, high, corner) < std::tie(other.low, other.high, other.corner);
  }
};

bool in_range(const TriangleMesh& mesh, const TriangleMesh::Face& face) {
  return std::all_of(face.begin(), face.end(),
                     [&](std::uint32_t vertex) { return vertex < mesh.vertices.size(); });
}

std::uint32_t corner_of(std::size_t face, std::size_t k) {
  return static_cast<std::uint32_t>(3 * face + k);
}

std::uint32_t next_corner(std::uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

// Whether a side runs from its lower to its higher vertex.
bool ascending(const TriangleMesh& mesh, const HalfEdge& side) {
  return mesh.faces[side.corner / 3][side.corner % 3] == side.low;
}

// By their lower vertices first, of which each has few.
std::vector<HalfEdge> sorted_half_edges(const TriangleMesh& mesh) {
  const auto visit = [&](const auto& side) {
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
        if (a != b) side(HalfEdge{std::min(a, b), std::max(a, b), corner_of(f, k)});
      }
    }
  };
  std::vector<std::uint32_t> end(mesh.vertices.size() + 1, 0);
  visit([&](const HalfEdge& side) { ++end[side.low + 1]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<HalfEdge> sides(end.back());
  visit([&](const HalfEdge& side) { sides[end[side.low]++] = side; });
  throw_if_stop_requested();
  auto begin = sides.begin();
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto last = sides.begin() + end[v];
    std::sort(begin, last);
    begin = last;
  }
  return sides;
}

// Joins the corners at both ends of an edge of two faces: they belong to the same fan.
void join_fans(const HalfEdge& a, const HalfEdge& b, bool same_direction, DisjointSets& fans) {
  const std::array<std::uint32_t, 2> a_ends{a.corner, next_corner(a.corner)};
  const std::array<std::uint32_t, 2> b_ends{b.corner, next_corner(b.corner)};
  for (const std::size_t end : {0u, 1u})
    fans.join(a_ends[end], b_ends[same_direction ? end : 1 - end]);
}

void count_edges(const TriangleMesh& mesh, DisjointSets& fans, MeshCheck& check) {
  const std::vector<HalfEdge> sides = sorted_half_edges(mesh);
  throw_if_stop_requested();
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].same_edge(sides[begin])) ++end;
    ++check.edges;
    check.boundary_edges += end - begin == 1;
    check.non_manifold_edges += end - begin > 2;
    if (end - begin == 2) {
      const bool same_direction =
          ascending(mesh, sides[begin]) == ascending(mesh, sides[begin + 1]);
      check.inconsistent_edges += same_direction;
      join_fans(sides[begin], sides[begin + 1], same_direction, fans);
    }
  }
}

void count_vertices(const TriangleMesh& mesh, DisjointSets& fans, MeshCheck& check) {
  std::vector<std::uint32_t> fan_count(mesh.vertices.size(), 0);
  DisjointSets components(mesh.vertices.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (fans.find(corner_of(f, k)) == corner_of(f, k)) ++fan_count[mesh.faces[f][k]];
      components.join(mesh.faces[f][0], mesh.faces[f][k]);
    }
  }
  for (std::uint32_t v = 0; v < fan_count.size(); ++v) {
    check.unused_vertices += fan_count[v] == 0;
    check.non_manifold_vertices += fan_count[v] > 1;
    check.components += fan_count[v] > 0 && components.find(v) == v;
    check.non_finite_vertices += !mesh.vertices[v].allFinite();
  }
}

std::size_t duplicate_vertices(const TriangleMesh& mesh) {
  std::vector<std::array<double, 3>> places;
  places.reserve(mesh.vertices.size());
  for (const auto& p : mesh.vertices)
    if (p.allFinite()) places.push_back({p.x(), p.y(), p.z()});
  std::sort(places.begin(), places.end());
  const auto first_repeated = std::unique(places.begin(), places.end());
  return static_cast<std::size_t>(places.end() - first_repeated);
}

// Whether a face has no area that doubles can tell from none.
bool degenerate(const TriangleMesh& mesh, std::size_t face) {
  double longest = 0.0;
  for (int k = 0; k < 3; ++k)
    longest =
        std::max(longest, (mesh.corner(face, (k + 1) % 3) - mesh.corner(face, k)).squaredNorm());
  return !(face_cross(mesh, face).norm() > 1e-12 * longest);
}

}  // namespace

bool MeshCheck::closed() const {
  return faces > 0 && boundary_edges == 0 && non_manifold_edges == 0 && inconsistent_edges == 0 &&
         invalid_faces == 0;
}

bool MeshCheck::manifold() const { return non_manifold_edges == 0 && non_manifold_vertices == 0; }

bool MeshCheck::watertight() const {
  return closed() && manifold() && degenerate_faces == 0 && duplicate_vertices == 0 &&
         unused_vertices == 0 && non_finite_vertices == 0 && volume > 0.0;
}

MeshCheck check_mesh(const TriangleMesh& mesh, const MeshCheckOptions& options) {
  TriangleMesh valid;
  const TriangleMesh* checked = &mesh;
  MeshCheck check;
  check.invalid_faces = static_cast<std::size_t>(std::count_if(
      mesh.faces.begin(), mesh.faces.end(), [&](const auto& f) { return !in_range(mesh, f); }));
  if (check.invalid_faces > 0) {
    valid.vertices = mesh.vertices;
    std::copy_if(mesh.faces.begin(), mesh.faces.end(), std::back_inserter(valid.faces),
                 [&](const auto& f) { return in_range(mesh, f); });
    checked = &valid;
  }
  check.vertices = mesh.vertices.size();
  check.faces = mesh.faces.size();
  assert(checked->faces.size() <= 0xffffffffu / 3);
  DisjointSets fans(3 * checked->faces.size());
  throw_if_stop_requested();  // Between passes: each takes tenths of a second for millions of
                              // faces.
  count_edges(*checked, fans, check);
  throw_if_stop_requested();
  count_vertices(*checked, fans, check);
  throw_if_stop_requested();
  check.duplicate_vertices = duplicate_vertices(*checked);
  for (std::size_t f = 0; f < checked->faces.size(); ++f)
    check.degenerate_faces += degenerate(*checked, f);
  check.volume = checked->faces.empty() ? 0.0 : enclosed_volume(*checked);
  if (check.closed() && check.manifold()) {
    // Euler and Poincare: V - E + F = 2 (components - genus).
    const auto used = static_cast<long>(check.vertices - check.unused_vertices);
    const long euler = used - static_cast<long>(check.edges) + static_cast<long>(check.faces);
    check.genus = static_cast<long>(check.components) - euler / 2;
  }
  if (options.self_intersections) check.self_intersections = find_self_intersections(mesh, {});
  return check;
}

}  // namespace relief
