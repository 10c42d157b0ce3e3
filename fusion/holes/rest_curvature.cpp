#include "fusion/holes/rest_curvature.h"

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace relief::fusion {

namespace {

// Edges over which measured curvatures are averaged. Noise in them falls with the square of it;
// they are known over six rings.
constexpr double kAveraged = 4.0;

// Edges from what was measured from which on the closed field has the curvature of the surface.
constexpr int kDeep = 8;

Eigen::Vector3d normal_at(const TriangleMesh& mesh, const FacesAround& around,
                          std::uint32_t vertex) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  around.visit(vertex, [&](std::uint32_t f) { normal += face_cross(mesh, f); });
  return normal.normalized();
}

Eigen::Vector3d bend_at(const TriangleMesh& mesh, const FacesAround& around, std::uint32_t vertex) {
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();
  visit_cotangents(mesh, around, vertex, [&](std::uint32_t other, double weight) {
    bend += weight * (mesh.vertices[other] - mesh.vertices[vertex]);
  });
  return bend;
}

// Edges from what was measured of the filled vertices of a region that are farther than kDeep are
// kDeep + 1.
std::unordered_map<std::uint32_t, int> depths_in(const MeshRings& of, const FairRegion& region) {
  std::unordered_map<std::uint32_t, int> depths;
  std::vector<std::uint32_t> ring;
  for (const PlateVertex& free : region.vertices) {
    if (of.rings[free.vertex] == 0)
      depths.emplace(free.vertex, kDeep + 1);
    else if (of.rings[free.vertex] == 1)
      ring.push_back(free.vertex);
  }
  for (int depth = 1; depth <= kDeep; ++depth) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t v : ring)
      of.around.visit(v, [&](std::uint32_t f) {
        for (const std::uint32_t w : of.mesh.faces[f]) {
          const auto found = depths.find(w);
          if (found == depths.end() || found->second <= kDeep) continue;
          found->second = depth;
          next.push_back(w);
        }
      });
    ring = std::move(next);
  }
  return depths;
}

}  // namespace

Eigen::VectorXd continued_curvature(const TriangleMesh& mesh, const FacesAround& around,
                                    const std::vector<std::uint32_t>& vertices,
                                    const std::vector<std::uint8_t>& known, double edge) {
  using Sparse = Eigen::SparseMatrix<double>;
  const auto size = static_cast<Eigen::Index>(vertices.size());
  std::unordered_map<std::uint32_t, int> row_of;
  for (const std::uint32_t v : vertices) row_of.emplace(v, static_cast<int>(row_of.size()));
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  for (int row = 0; row < size; ++row) {
    const std::uint32_t v = vertices[static_cast<std::size_t>(row)];
    visit_cotangents(mesh, around, v, [&](std::uint32_t other, double weight) {
      const auto column = row_of.find(other);
      if (column == row_of.end()) return;
      entries.emplace_back(row, column->second, -weight);
      entries.emplace_back(row, row, weight);
    });
    if (!known[static_cast<std::size_t>(row)]) continue;
    const double share = 1.0 / (kAveraged * edge * kAveraged * edge);
    entries.emplace_back(row, row, share * area_at(mesh, around, v));
    right(row) = -share * bend_at(mesh, around, v).dot(normal_at(mesh, around, v));
  }
  if (right.isZero()) return right;
  Sparse system(size, size);
  system.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Sparse> factor(system);
  if (factor.info() != Eigen::Success) return Eigen::VectorXd::Zero(size);
  const Eigen::VectorXd curvature = factor.solve(right);
  return curvature.allFinite() ? curvature : Eigen::VectorXd(Eigen::VectorXd::Zero(size));
}

// Of a sphere that grows by u, 2 H changes by -2 H^2 u, where the normal stays: twice that is (2
// H)^2.
void bend_to(const TriangleMesh& mesh, const FacesAround& around, const Eigen::VectorXd& curvature,
             FairRegion& region) {
  Eigen::Index k = 0;
  const auto set = [&](PlateVertex& vertex) {
    const std::uint32_t v = vertex.vertex;
    const Eigen::Vector3d normal = normal_at(mesh, around, v);
    const Eigen::Vector3d along = bend_at(mesh, around, v) / area_at(mesh, around, v);
    vertex.rest = along - (along.dot(normal) + curvature(k)) * normal;
    vertex.growth = curvature(k) * curvature(k);
    ++k;
  };
  for (PlateVertex& vertex : region.vertices) set(vertex);
  for (PlateVertex& vertex : region.border) set(vertex);
}

void set_rest_curvature(const MeshRings& of, double voxel, FairRegion& region) {
  const std::vector<std::uint32_t> vertices = region.with_approach();
  const std::unordered_map<std::uint32_t, int> depths = depths_in(of, region);
  std::vector<std::uint8_t> known;
  for (const std::uint32_t v : vertices) {
    const auto depth = depths.find(v);
    known.push_back(of.rings[v] > MeshRings::kMargin ||
                    (depth != depths.end() && depth->second > kDeep));
  }
  bend_to(of.mesh, of.around, continued_curvature(of.mesh, of.around, vertices, known, voxel),
          region);
}

}  // namespace relief::fusion
