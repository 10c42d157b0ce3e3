#include "fusion/mesh/handle_loops.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <unordered_map>
#include <utility>

#include "scan/base/disjoint_sets.h"

namespace relief::fusion {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr double kFar = std::numeric_limits<double>::infinity();

// Roots that are tried one after the other, all over the patch. Bounds the time.
constexpr std::size_t kRoots = 24;

// How many times as long edges count that are not between marked vertices: loops run along these
// where they can. Changes which of many loops is found.
constexpr double kUnmarked = 3.0;

struct InnerEdge {
  std::uint32_t a, b;         // Vertices of the patch.
  std::uint32_t left, right;  // Faces of the patch.
  double length;              // As it counts [unit].
};

// The faces, vertices and inner edges of a patch, numbered from 0.
class Patch {
 public:
  Patch(const TriangleMesh& mesh, std::span<const std::uint32_t> faces,
        std::span<const std::uint8_t> marked)
      : faces_(faces.size()) {
    std::unordered_map<std::uint64_t, std::uint32_t> face_at;  // By half-edge.
    for (std::uint32_t f = 0; f < faces.size(); ++f)
      for (std::size_t k = 0; k < 3; ++k) face_at.emplace(half_edge(mesh.faces[faces[f]], k), f);
    std::vector<bool> inside;
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
      const auto& face = mesh.faces[faces[f]];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t from = face[k], to = face[(k + 1) % 3];
        const std::uint32_t a = number_of(from), b = number_of(to);
        inside.resize(vertices_.size(), true);
        const auto beyond = face_at.find(std::uint64_t{to} << 32 | from);
        if (beyond == face_at.end())
          inside[a] = inside[b] = false;
        else if (from < to)
          edges_.push_back({a, b, f, beyond->second,
                            (marked[from] && marked[to] ? 1.0 : kUnmarked) *
                                (mesh.vertices[to] - mesh.vertices[from]).norm()});
      }
    }
    incident_.resize(vertices_.size());
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      if (!inside[edges_[e].a] || !inside[edges_[e].b]) continue;
      incident_[edges_[e].a].push_back(e);
      incident_[edges_[e].b].push_back(e);
    }
  }

  std::size_t faces() const { return faces_; }
  std::size_t vertices() const { return vertices_.size(); }
  const std::vector<InnerEdge>& edges() const { return edges_; }
  HandleLoop in_mesh(HandleLoop loop) const {
    for (std::uint32_t& v : loop.vertices) v = vertices_[v];
    return loop;
  }
  // Of the edges that loops may take, those at a vertex.
  const std::vector<std::uint32_t>& incident(std::uint32_t v) const { return incident_[v]; }

 private:
  static std::uint64_t half_edge(const TriangleMesh::Face& face, std::size_t k) {
    return std::uint64_t{face[k]} << 32 | face[(k + 1) % 3];
  }
  std::uint32_t number_of(std::uint32_t vertex) {
    const auto [found, fresh] =
        numbers_.emplace(vertex, static_cast<std::uint32_t>(vertices_.size()));
    if (fresh) vertices_.push_back(vertex);
    return found->second;
  }

  std::size_t faces_;
  std::unordered_map<std::uint32_t, std::uint32_t> numbers_;
  std::vector<std::uint32_t> vertices_;
  std::vector<InnerEdge> edges_;
  std::vector<std::vector<std::uint32_t>> incident_;
};

// The shortest paths from a vertex, as far as a distance.
class PathTree {
 public:
  PathTree(const Patch& patch, std::uint32_t root, double farthest)
      : patch_(patch), distance_(patch.vertices(), kFar), edge_(patch.vertices(), kNone) {
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    distance_[root] = 0.0;
    queue.emplace(0.0, root);
    while (!queue.empty()) {
      const auto [distance, v] = queue.top();
      queue.pop();
      if (distance > distance_[v]) continue;
      for (const std::uint32_t e : patch.incident(v)) {
        const std::uint32_t other = beyond(e, v);
        const double there = distance + patch.edges()[e].length;
        if (!(there < std::min(distance_[other], farthest))) continue;
        distance_[other] = there;
        edge_[other] = e;
        queue.emplace(there, other);
      }
    }
  }

  bool has(std::uint32_t e) const {
    return edge_[patch_.edges()[e].a] == e || edge_[patch_.edges()[e].b] == e;
  }
  // From the root along the tree to one end of an edge, across it and back; infinite where the tree
  // does not reach it.
  double length_through(std::uint32_t e) const {
    const InnerEdge& edge = patch_.edges()[e];
    return distance_[edge.a] + distance_[edge.b] + edge.length;
  }
  // The same without the way that both paths share.
  HandleLoop loop_through(std::uint32_t e) const {
    const InnerEdge& edge = patch_.edges()[e];
    std::vector<std::uint32_t> there = path_to_root(edge.a), back = path_to_root(edge.b);
    std::uint32_t shared = there.back();
    while (!there.empty() && !back.empty() && there.back() == back.back()) {
      shared = there.back();
      there.pop_back();
      back.pop_back();
    }
    HandleLoop loop;
    loop.length = length_through(e) - 2.0 * distance_[shared];
    loop.vertices = std::move(there);
    loop.vertices.push_back(shared);
    loop.vertices.insert(loop.vertices.end(), back.rbegin(), back.rend());
    return loop;
  }

 private:
  std::uint32_t beyond(std::uint32_t e, std::uint32_t v) const {
    const InnerEdge& edge = patch_.edges()[e];
    return edge.a == v ? edge.b : edge.a;
  }
  std::vector<std::uint32_t> path_to_root(std::uint32_t v) const {
    std::vector<std::uint32_t> path = {v};
    while (edge_[v] != kNone) path.push_back(v = beyond(edge_[v], v));
    return path;
  }

  const Patch& patch_;
  std::vector<double> distance_;     // [unit]
  std::vector<std::uint32_t> edge_;  // Towards the root.
};

// The shortest acceptable one of the loops from the root that are independent of each other. The
// faces are joined across edges that are not in the tree, those with the longest loops first. Loops
// through the edges that are left cross none of these, so they do not part the patch.
std::optional<HandleLoop> loop_from(const Patch& patch, const PathTree& tree,
                                    const AcceptLoop& accept) {
  DisjointSets joined(patch.faces());
  const auto join_across = [&](std::uint32_t e) {
    return joined.join(patch.edges()[e].left, patch.edges()[e].right);
  };
  std::vector<std::uint32_t> reached;
  for (std::uint32_t e = 0; e < patch.edges().size(); ++e) {
    if (tree.has(e)) continue;
    if (tree.length_through(e) < kFar)
      reached.push_back(e);
    else
      join_across(e);
  }
  std::ranges::stable_sort(reached, std::ranges::greater(),
                           [&](std::uint32_t e) { return tree.length_through(e); });
  std::vector<HandleLoop> loops;
  for (const std::uint32_t e : reached)
    if (!join_across(e)) loops.push_back(patch.in_mesh(tree.loop_through(e)));
  std::ranges::stable_sort(loops, {}, &HandleLoop::length);
  const auto found = std::ranges::find_if(loops, accept);
  return found == loops.end() ? std::nullopt : std::optional(std::move(*found));
}

}  // namespace

std::optional<HandleLoop> short_handle_loop(const TriangleMesh& mesh,
                                            std::span<const std::uint32_t> patch_faces,
                                            std::span<const std::uint8_t> marked,
                                            const AcceptLoop& accept) {
  const Patch patch(mesh, patch_faces, marked);
  std::optional<HandleLoop> best;
  const std::size_t stride = 1 + patch.vertices() / kRoots;
  for (std::size_t v = 0; v < patch.vertices(); v += stride) {
    const auto root = static_cast<std::uint32_t>(v);
    if (patch.incident(root).empty()) continue;
    // A shorter loop lies within half the length of the best one round its root.
    const PathTree tree(patch, root, best ? 0.5 * best->length : kFar);
    auto loop = loop_from(patch, tree, accept);
    if (loop && (!best || loop->length < best->length)) best = std::move(loop);
  }
  return best;
}

}  // namespace relief::fusion
