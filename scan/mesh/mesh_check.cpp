#include "relief/scan/mesh_check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "scan/base/counter_random.h"
#include "scan/base/disjoint_sets.h"
#include "scan/base/memory/paged_array.h"
#include "scan/base/parallel.h"

namespace relief {

namespace {

constexpr std::size_t kAtOnce = 1 << 14;  // Vertices or faces of one piece of work.

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

using HalfEdges = PagedArray<HalfEdge>;

// By their lower vertices first, of which each has few.
HalfEdges sorted_half_edges(const TriangleMesh& mesh) {
  const auto visit = [&](const auto& side) {
    serial_for(mesh.faces.size(), [&](std::size_t f) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
        if (a != b) side(HalfEdge{std::min(a, b), std::max(a, b), corner_of(f, k)});
      }
    });
  };
  // First where the sides of each vertex begin, at last where they end.
  PagedArray<std::uint32_t> place(mesh.vertices.size());
  visit([&](const HalfEdge& side) { ++place[side.low]; });
  std::uint32_t count = 0;
  serial_for(place.size(), [&](std::size_t v) { count += std::exchange(place[v], count); });
  HalfEdges sides(count);
  visit([&](const HalfEdge& side) { sides[place[side.low]++] = side; });
  parallel_for(place.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v)
      std::sort(sides.begin() + (v == 0 ? 0 : place[v - 1]), sides.begin() + place[v]);
  });
  return sides;
}

// Joins the corners at both ends of an edge of two faces: they belong to the same fan.
void join_fans(const HalfEdge& a, const HalfEdge& b, bool same_direction, DisjointSets& fans) {
  const std::array<std::uint32_t, 2> a_ends{a.corner, next_corner(a.corner)};
  const std::array<std::uint32_t, 2> b_ends{b.corner, next_corner(b.corner)};
  for (const std::size_t end : {0u, 1u})
    fans.join(a_ends[end], b_ends[same_direction ? end : 1 - end]);
}

// The sides of one edge.
void count_edge(const TriangleMesh& mesh, std::span<const HalfEdge> sides, DisjointSets& fans,
                MeshCheck& check) {
  ++check.edges;
  check.boundary_edges += sides.size() == 1;
  check.non_manifold_edges += sides.size() > 2;
  if (sides.size() != 2) return;
  const bool same_direction = ascending(mesh, sides[0]) == ascending(mesh, sides[1]);
  check.inconsistent_edges += same_direction;
  join_fans(sides[0], sides[1], same_direction, fans);
}

void count_edges(const TriangleMesh& mesh, DisjointSets& fans, MeshCheck& check) {
  const HalfEdges sides = sorted_half_edges(mesh);
  std::size_t begin = 0;
  serial_for(sides.size(), [&](std::size_t i) {
    const std::size_t end = i + 1;
    if (end < sides.size() && sides[end].same_edge(sides[begin])) return;
    count_edge(mesh, sides.span().subspan(begin, end - begin), fans, check);
    begin = end;
  });
}

void count_vertices(const TriangleMesh& mesh, DisjointSets& fans, MeshCheck& check) {
  PagedArray<std::uint32_t> fan_count(mesh.vertices.size());
  DisjointSets components(mesh.vertices.size());
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (fans.find(corner_of(f, k)) == corner_of(f, k)) ++fan_count[mesh.faces[f][k]];
      components.join(mesh.faces[f][0], mesh.faces[f][k]);
    }
  });
  serial_for(fan_count.size(), [&](std::size_t v) {
    check.unused_vertices += fan_count[v] == 0;
    check.non_manifold_vertices += fan_count[v] > 1;
    check.components += fan_count[v] > 0 && components.find(static_cast<std::uint32_t>(v)) == v;
  });
}

using Place = std::array<double, 3>;

// By a hash, so that a part holds all vertices of a place. -0 and 0 are one.
std::size_t part_of(const Eigen::Vector3d& p, std::size_t parts) {
  std::uint64_t hash = 0;
  for (const double x : p)
    hash = CounterRandom::scrambled(hash ^ std::bit_cast<std::uint64_t>(x + 0.0));
  return hash % parts;
}

// Sorts the places in parts that fit into memory.
std::size_t duplicate_vertices(const TriangleMesh& mesh) {
  constexpr std::size_t kPart = 1 << 16;  // About as many in each; changes no result.
  const std::size_t parts = mesh.vertices.size() / kPart + 1;
  const auto visit = [&](const auto& finite) {
    serial_for(mesh.vertices.size(), [&](std::size_t v) {
      const Eigen::Vector3d& p = mesh.vertices[v];
      if (p.allFinite()) finite(part_of(p, parts), p);
    });
  };
  std::vector<std::size_t> end(parts + 1, 0);
  visit([&](std::size_t part, const Eigen::Vector3d&) { ++end[part + 1]; });
  std::partial_sum(end.begin(), end.end(), end.begin());
  PagedArray<Place> places(end.back());
  visit([&](std::size_t part, const Eigen::Vector3d& p) {
    places[end[part]++] = {p.x(), p.y(), p.z()};
  });
  return parallel_sum<std::size_t>(parts, 1, 0, [&](std::size_t part, std::size_t) {
    Place *const first = places.begin() + (part == 0 ? 0 : end[part - 1]), *const last =
                                                                               places.begin() +
                                                                               end[part];
    std::sort(first, last);
    return static_cast<std::size_t>(last - std::unique(first, last));
  });
}

// Whether a face has no area that doubles can tell from none.
bool degenerate(const TriangleMesh& mesh, std::size_t face) {
  double longest = 0.0;
  for (int k = 0; k < 3; ++k)
    longest =
        std::max(longest, (mesh.corner(face, (k + 1) % 3) - mesh.corner(face, k)).squaredNorm());
  return !(face_cross(mesh, face).norm() > 1e-12 * longest);
}

// What depends on where the vertices are.
void count_by_places(const TriangleMesh& mesh, MeshCheck& check) {
  const auto sum_of = [](std::size_t count, const auto& is_one) {
    return parallel_sum<std::size_t>(count, kAtOnce, 0, [&](std::size_t begin, std::size_t end) {
      std::size_t sum = 0;
      for (std::size_t i = begin; i < end; ++i) sum += is_one(i);
      return sum;
    });
  };
  check.non_finite_vertices =
      sum_of(mesh.vertices.size(), [&](std::size_t v) { return !mesh.vertices[v].allFinite(); });
  check.duplicate_vertices = duplicate_vertices(mesh);
  check.degenerate_faces =
      sum_of(mesh.faces.size(), [&](std::size_t f) { return degenerate(mesh, f); });
  check.volume = mesh.faces.empty() ? 0.0 : enclosed_volume(mesh);
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
  serial_for(mesh.faces.size(),
             [&](std::size_t f) { check.invalid_faces += !in_range(mesh, mesh.faces[f]); });
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
  count_edges(*checked, fans, check);
  count_vertices(*checked, fans, check);
  count_by_places(*checked, check);
  if (check.closed() && check.manifold()) {
    // Euler and Poincare: V - E + F = 2 (components - genus).
    const auto used = static_cast<long>(check.vertices - check.unused_vertices);
    const long euler = used - static_cast<long>(check.edges) + static_cast<long>(check.faces);
    check.genus = static_cast<long>(check.components) - euler / 2;
  }
  if (options.self_intersections) check.self_intersections = find_self_intersections(mesh, {});
  return check;
}

MeshCheck check_moved_vertices(const TriangleMesh& mesh, MeshCheck before) {
  const bool same_size =
      mesh.vertices.size() == before.vertices && mesh.faces.size() == before.faces;
  if (!same_size || before.invalid_faces > 0) return check_mesh(mesh);
  count_by_places(mesh, before);
  before.self_intersections.reset();
  return before;
}

}  // namespace relief
