#include "fusion/holes/rest_curvature.h"

#include <unordered_map>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace relief::fusion {

namespace {

// Edges over which measured curvatures are averaged. Noise in them falls with the square of it;
// they are known over six rings.
constexpr double kAveraged = 4.0;

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

}  // namespace relief::fusion
