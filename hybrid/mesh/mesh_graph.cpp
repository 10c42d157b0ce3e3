#include "hybrid/mesh/mesh_graph.h"

#include <algorithm>
#include <vector>

#include "scan/base/parallel.h"

namespace relief::hybrid {

namespace {

constexpr std::size_t kGrain = 4096;  // Of one piece of work; changes no result.

// The faces at each vertex, in rising order.
struct FaceLists {
  PagedArray<std::size_t> begin;
  PagedArray<std::uint32_t> face;
};

FaceLists faces_at_vertices(const TriangleMesh& mesh) {
  FaceLists lists{PagedArray<std::size_t>(mesh.vertices.size() + 2), {}};
  const auto visit = [&](const auto& body) {
    serial_for(mesh.faces.size(), [&](std::size_t f) {
      for (const std::uint32_t v : mesh.faces[f]) body(v, static_cast<std::uint32_t>(f));
    });
  };
  // Until all faces are there, the beginning of a vertex is one place farther.
  visit([&](std::uint32_t v, std::uint32_t) { ++lists.begin[v + 2]; });
  sum_up(lists.begin);
  lists.face = PagedArray<std::uint32_t>(3 * mesh.faces.size());
  visit([&](std::uint32_t v, std::uint32_t f) { lists.face[lists.begin[v + 1]++] = f; });
  return lists;
}

}  // namespace

void sum_up(PagedArray<std::size_t>& begin) {
  std::size_t sum = 0;
  serial_for(begin.size(), [&](std::size_t i) { begin[i] = sum += begin[i]; });
}

MeshGraph mesh_graph(const TriangleMesh& mesh) {
  const FaceLists lists = faces_at_vertices(mesh);
  const std::size_t count = mesh.vertices.size();
  PagedArray<double> third(mesh.faces.size());
  parallel_for(third.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) third[f] = face_cross(mesh, f).norm() / 6.0;
  });

  // A vertex has at most two edges per face; closed meshes have half as many.
  struct Edge {
    std::uint32_t neighbour;
    double area;
  };
  const auto edges_of = [&](std::size_t vertex, std::vector<Edge>& edges) {
    edges.clear();
    for (std::size_t k = lists.begin[vertex]; k < lists.begin[vertex + 1]; ++k)
      for (const std::uint32_t other : mesh.faces[lists.face[k]])
        if (other != vertex) edges.push_back({other, third[lists.face[k]]});
    std::stable_sort(edges.begin(), edges.end(),
                     [](const Edge& a, const Edge& b) { return a.neighbour < b.neighbour; });
    std::size_t kept = 0;
    for (std::size_t k = 0; k < edges.size(); ++k) {
      if (kept > 0 && edges[kept - 1].neighbour == edges[k].neighbour)
        edges[kept - 1].area += edges[k].area;
      else
        edges[kept++] = edges[k];
    }
    edges.resize(kept);
  };

  MeshGraph graph;
  graph.begin = PagedArray<std::size_t>(count + 1);
  graph.vertex_area = PagedArray<float>(count);
  parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Edge> edges;
    for (std::size_t i = begin; i < end; ++i) {
      edges_of(i, edges);
      graph.begin[i + 1] = edges.size();
    }
  });
  sum_up(graph.begin);
  graph.neighbour = PagedArray<std::uint32_t>(graph.begin[count]);
  graph.edge_area = PagedArray<float>(graph.begin[count]);
  parallel_for(count, kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Edge> edges;
    for (std::size_t i = begin; i < end; ++i) {
      edges_of(i, edges);
      for (std::size_t k = 0; k < edges.size(); ++k) {
        graph.neighbour[graph.begin[i] + k] = edges[k].neighbour;
        graph.edge_area[graph.begin[i] + k] = static_cast<float>(edges[k].area);
      }
      double area = 0.0;
      for (std::size_t k = lists.begin[i]; k < lists.begin[i + 1]; ++k)
        area += third[lists.face[k]];
      graph.vertex_area[i] = static_cast<float>(area);
    }
  });
  return graph;
}

}  // namespace relief::hybrid
