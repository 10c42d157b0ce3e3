#include "fusion/manifold_repair.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

namespace relief {

namespace {

using Face = TriangleMesh::Face;

// A side of a face, from `from` to `to`.
struct Side {
  std::uint32_t low, high;
  std::uint32_t face;
  bool ascending;
  bool operator<(const Side& o) const {
    return std::tie(low, high, ascending, face) < std::tie(o.low, o.high, o.ascending, o.face);
  }
};

std::vector<Side> sorted_sides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.faces.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.faces[f][k], b = mesh.faces[f][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(f), a < b});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

std::uint32_t apex(const Face& face, std::uint32_t a, std::uint32_t b) {
  for (const std::uint32_t v : face)
    if (v != a && v != b) return v;
  return a;
}

// Four faces round the edge (low, high): the first two run it downwards, the others upwards.
struct SharedEdge {
  std::uint32_t low, high;
  std::array<std::uint32_t, 4> faces;
};

std::vector<SharedEdge> shared_edges(const std::vector<Side>& sides) {
  std::vector<SharedEdge> shared;
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].low == sides[begin].low &&
           sides[end].high == sides[begin].high)
      ++end;
    if (end - begin != 4) continue;
    shared.push_back(
        {sides[begin].low,
         sides[begin].high,
         {sides[begin].face, sides[begin + 1].face, sides[begin + 2].face, sides[begin + 3].face}});
  }
  return shared;
}

// Walks round vertex `low` from face to face, away from the shared edge, until it meets that edge
// again: the face where it arrives is on the other sheet, or the fan at `low` would close there.
class FanWalk {
 public:
  FanWalk(const TriangleMesh& mesh, const std::vector<Side>& sides) : mesh_(mesh), sides_(sides) {}

  std::uint32_t arrive(const SharedEdge& edge, std::uint32_t start) const {
    std::uint32_t face = start;
    std::uint32_t spoke = apex(mesh_.faces[face], edge.low, edge.high);
    while (spoke != edge.high) {
      face = across(edge.low, spoke, face);
      spoke = apex(mesh_.faces[face], edge.low, spoke);
    }
    return face;
  }

 private:
  std::uint32_t across(std::uint32_t a, std::uint32_t b, std::uint32_t face) const {
    const Side first{std::min(a, b), std::max(a, b), 0, false};
    auto side = std::lower_bound(sides_.begin(), sides_.end(), first);
    return side->face == face ? (side + 1)->face : side->face;
  }

  const TriangleMesh& mesh_;
  const std::vector<Side>& sides_;
};

// Replaces each of two faces of one sheet by two that meet at `middle` on their common edge.
void split_pair(TriangleMesh& mesh, const SharedEdge& edge, std::array<std::uint32_t, 2> pair,
                std::uint32_t middle) {
  for (const std::uint32_t f : pair) {
    Face near_low = mesh.faces[f], near_high = mesh.faces[f];
    std::replace(near_low.begin(), near_low.end(), edge.high, middle);
    std::replace(near_high.begin(), near_high.end(), edge.low, middle);
    mesh.faces[f] = near_low;
    mesh.faces.push_back(near_high);
  }
}

}  // namespace

std::size_t split_shared_diagonals(Isosurface& surface) {
  TriangleMesh& mesh = surface.mesh;
  std::size_t count = 0;
  // Splitting a face leaves the recorded sides stale, so edges that share a face with one already
  // split wait for the next round.
  for (;;) {
    const std::vector<Side> sides = sorted_sides(mesh);
    const std::vector<SharedEdge> shared = shared_edges(sides);
    if (shared.empty()) return count;
    std::vector<std::uint8_t> touched(mesh.faces.size(), 0);
    const FanWalk walk(mesh, sides);
    std::vector<std::pair<SharedEdge, std::array<std::uint32_t, 2>>> splits;
    for (const SharedEdge& edge : shared) {
      const auto& f = edge.faces;
      if (std::any_of(f.begin(), f.end(), [&](std::uint32_t face) { return touched[face]; }))
        continue;
      const std::uint32_t other_sheet = walk.arrive(edge, f[0]);
      splits.push_back({edge, {f[0], other_sheet == f[2] ? f[3] : f[2]}});
      for (const std::uint32_t face : f) touched[face] = 1;
    }
    for (const auto& [edge, pair] : splits) {
      const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
      // A little towards the sheet's own side of the cells' common face.
      const Eigen::Vector3d on_edge = 0.5 * (mesh.vertices[edge.low] + mesh.vertices[edge.high]);
      const Eigen::Vector3d beside =
          0.5 * (mesh.vertices[apex(mesh.faces[pair[0]], edge.low, edge.high)] +
                 mesh.vertices[apex(mesh.faces[pair[1]], edge.low, edge.high)]);
      mesh.vertices.push_back(on_edge + 0.1 * (beside - on_edge));
      surface.edges.push_back(surface.edges[edge.low]);
      split_pair(mesh, edge, pair, middle);
      ++count;
    }
  }
}

}  // namespace relief
