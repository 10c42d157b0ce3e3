#include "scan/simulation/objects/geodesic_sphere.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <map>
#include <numbers>
#include <utility>

namespace relief::simulation {

namespace {

using Index = std::uint32_t;

struct Icosahedron {
  PagedVector<Eigen::Vector3d> corners;
  std::array<TriangleMesh::Face, 20> faces;
};

Icosahedron icosahedron() {
  constexpr double g = std::numbers::phi;
  Icosahedron solid;
  solid.corners = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  solid.faces = {{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                  {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                  {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                  {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};
  return solid;
}

class Subdivider {
 public:
  explicit Subdivider(int divisions) : divisions_(divisions) {
    mesh_.vertices = solid_.corners;
    for (const auto& face : solid_.faces) add_face(face);
    for (auto& vertex : mesh_.vertices) vertex.normalize();
  }

  TriangleMesh take() { return std::move(mesh_); }

 private:
  // The interior points of an edge, in order from the corner of the smaller index.
  const std::vector<Index>& edge_points(Index a, Index b) {
    auto& points = edges_[std::minmax(a, b)];
    if (points.empty()) {
      const auto [first, last] = std::minmax(a, b);
      for (int i = 1; i < divisions_; ++i)
        points.push_back(add_vertex(solid_.corners[first], solid_.corners[last],
                                    static_cast<double>(i) / divisions_));
    }
    return points;
  }

  Index add_vertex(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double s) {
    mesh_.vertices.push_back((1.0 - s) * a + s * b);
    return static_cast<Index>(mesh_.vertices.size() - 1);
  }

  // Point i of `divisions` + 1 along the edge from corner a to corner b.
  Index edge_point(Index a, Index b, int i) {
    if (i == 0) return a;
    if (i == divisions_) return b;
    return edge_points(a, b)[static_cast<std::size_t>(a < b ? i - 1 : divisions_ - 1 - i)];
  }

  // Rows run parallel to the edge bc, from corner a.
  void add_face(const TriangleMesh::Face& face) {
    const auto [a, b, c] = face;
    std::vector<Index> above = {a};
    for (int row = 1; row <= divisions_; ++row) {
      std::vector<Index> here = {edge_point(a, b, row)};
      const Index last = edge_point(a, c, row);
      for (int i = 1; i < row; ++i) here.push_back(row_point(b, c, here.front(), last, row, i));
      here.push_back(last);
      for (std::size_t i = 0; i < above.size(); ++i) {
        mesh_.faces.push_back({above[i], here[i], here[i + 1]});
        if (i + 1 < above.size()) mesh_.faces.push_back({above[i], here[i + 1], above[i + 1]});
      }
      above = std::move(here);
    }
  }

  Index row_point(Index b, Index c, Index first, Index last, int row, int i) {
    if (row == divisions_) return edge_point(b, c, i);
    return add_vertex(mesh_.vertices[first], mesh_.vertices[last], static_cast<double>(i) / row);
  }

  int divisions_;
  Icosahedron solid_ = icosahedron();
  std::map<std::pair<Index, Index>, std::vector<Index>> edges_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh geodesic_sphere(int divisions) {
  assert(divisions >= 1);
  return Subdivider(divisions).take();
}

}  // namespace relief::simulation
