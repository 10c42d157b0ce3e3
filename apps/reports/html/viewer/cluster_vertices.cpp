#include "apps/reports/html/viewer/cluster_vertices.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "scan/base/disjoint_sets.h"
#include "scan/base/parallel.h"

namespace relief {

namespace {

struct Cluster {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // Sum of those of its vertices.
  double count = 0.0;
  std::uint32_t nearest = 0;  // The vertex that stands for all.
  double distance = std::numeric_limits<double>::infinity();
};

class Clusters {
 public:
  Clusters(const TriangleMesh& mesh, double cell) : mesh_(mesh) {
    const Eigen::AlignedBox3d box = bounding_box(mesh);
    low_ = box.min();
    cell_ = std::max(cell, box.sizes().maxCoeff() / kMostCells);
    gather();
    choose();
    for (int round = 0; round < kRounds && unfold(); ++round) choose();
  }

  TriangleMesh mesh() const {
    TriangleMesh coarse;
    for (const Cluster& cluster : clusters_) {
      const std::uint32_t v = cluster.nearest;
      coarse.vertices.push_back(mesh_.vertices[v]);
      if (!mesh_.quality.empty()) coarse.quality.push_back(mesh_.quality[v]);
      if (!mesh_.views.empty()) coarse.views.push_back(mesh_.views[v]);
      if (!mesh_.source_views.empty()) coarse.source_views.push_back(mesh_.source_views[v]);
      if (!mesh_.filled.empty()) coarse.filled.push_back(mesh_.filled[v]);
      if (!mesh_.colours.empty()) coarse.colours.push_back(mesh_.colours[v]);
    }
    for (const TriangleMesh::Face& face : mesh_.faces) {
      const TriangleMesh::Face joined = joined_face(face);
      if (has_three(joined)) coarse.faces.push_back(joined);
    }
    return coarse;
  }

 private:
  static constexpr double kMostCells = 1 << 20;
  static constexpr std::size_t kBetweenStops = 65536;  // Vertices; changes no result.
  static constexpr int kRounds = 20;
  static constexpr std::uint32_t kNone = 0xffffffffu;

  TriangleMesh::Face joined_face(const TriangleMesh::Face& face) const {
    return {of_[face[0]], of_[face[1]], of_[face[2]]};
  }

  static bool has_three(const TriangleMesh::Face& face) {
    return face[0] != face[1] && face[1] != face[2] && face[2] != face[0];
  }

  std::uint64_t cube_of(const Eigen::Vector3d& vertex) const {
    std::uint64_t cube = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double place = (vertex - low_)[axis] / cell_;
      cube = cube << 20 | static_cast<std::uint64_t>(std::min(place, kMostCells - 1.0));
    }
    return cube;
  }

  // Two clusters at most in a cube: vertices that face as its first one does, and the others.
  // Clusters are numbered in the order of their first vertices.
  void gather() {
    const auto normals =
        mesh_.normals.size() == mesh_.vertices.size() ? mesh_.normals : vertex_normals(mesh_);
    struct Cube {
      std::size_t first;
      std::array<std::uint32_t, 2> clusters{kNone, kNone};
    };
    std::unordered_map<std::uint64_t, Cube> cubes;
    of_.reserve(mesh_.vertices.size());
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
      if (v % kBetweenStops == 0) check_stop_and_memory();
      Cube& cube = cubes.try_emplace(cube_of(mesh_.vertices[v]), Cube{v}).first->second;
      auto& number = cube.clusters[normals[v].dot(normals[cube.first]) < 0.0f ? 1 : 0];
      if (number == kNone) {
        number = static_cast<std::uint32_t>(clusters_.size());
        clusters_.emplace_back();
      }
      of_.push_back(number);
      clusters_[number].sum += mesh_.vertices[v];
      clusters_[number].normal += normals[v].cast<double>();
      clusters_[number].count += 1.0;
    }
  }

  void choose() {
    for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) {
      if (v % kBetweenStops == 0) check_stop_and_memory();
      Cluster& cluster = clusters_[of_[v]];
      const double distance = (mesh_.vertices[v] - cluster.sum / cluster.count).squaredNorm();
      if (!(distance < cluster.distance)) continue;
      cluster.distance = distance;
      cluster.nearest = static_cast<std::uint32_t>(v);
    }
  }

  const Eigen::Vector3d& place(std::uint32_t cluster) const {
    return mesh_.vertices[clusters_[cluster].nearest];
  }

  // Whether a face looks to the other side than the surface that its corners stand for.
  bool is_folded(const TriangleMesh::Face& face) const {
    const Eigen::Vector3d cross =
        (place(face[1]) - place(face[0])).cross(place(face[2]) - place(face[0]));
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (const std::uint32_t c : face) normal += clusters_[c].normal.normalized();
    return cross.dot(normal) <= 0.0;
  }

  // Joins the ends of the shortest side of each folded face. Whether there were any.
  bool unfold() {
    DisjointSets sets(clusters_.size());
    bool any = false;
    for (const TriangleMesh::Face& face : mesh_.faces) {
      const TriangleMesh::Face joined = joined_face(face);
      if (!has_three(joined) || !is_folded(joined)) continue;
      const auto length = [&](int k) {
        return (place(joined[k]) - place(joined[(k + 1) % 3])).squaredNorm();
      };
      int shortest = length(1) < length(0) ? 1 : 0;
      if (length(2) < length(shortest)) shortest = 2;
      sets.join(joined[shortest], joined[(shortest + 1) % 3]);
      any = true;
    }
    if (any) join(sets);
    return any;
  }

  void join(DisjointSets& sets) {
    std::vector<Cluster> joined;
    std::vector<std::uint32_t> number(clusters_.size());
    for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
      const std::uint32_t first = sets.find(c);  // No larger than c.
      number[c] = first == c ? static_cast<std::uint32_t>(joined.size()) : number[first];
      if (first == c) joined.emplace_back();
      Cluster& cluster = joined[number[c]];
      cluster.sum += clusters_[c].sum;
      cluster.normal += clusters_[c].normal;
      cluster.count += clusters_[c].count;
    }
    for (std::uint32_t& cluster : of_) cluster = number[cluster];
    clusters_ = std::move(joined);
  }

  const TriangleMesh& mesh_;
  Eigen::Vector3d low_;
  double cell_;
  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> of_;  // The cluster of each vertex.
};

}  // namespace

TriangleMesh cluster_vertices(const TriangleMesh& mesh, double cell) {
  return Clusters(mesh, cell).mesh();
}

}  // namespace relief
