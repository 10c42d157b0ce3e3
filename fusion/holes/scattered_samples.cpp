#include "fusion/holes/scattered_samples.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <tuple>

#include <Eigen/Core>

#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/parallel.h"
#include "scan/mesh/triangle_tree.h"

namespace relief::fusion {

namespace {

// A sample tells of the surface that it lies over: the way to it is within 60 degrees of the
// normal. Beyond the rim of what is wanted, and over the other side of an edge, it is not.
constexpr double kLeastCosine = 0.5;

// What a face and its part of the tree take [bytes].
constexpr std::size_t kFace = 200;

struct Sample {
  std::uint32_t vertex;
  double offset, weight;
  bool operator<(const Sample& other) const {
    return std::tie(vertex, offset, weight) < std::tie(other.vertex, other.offset, other.weight);
  }
};

// The wanted faces alone, and which vertices of the mesh theirs are.
struct Part {
  TriangleMesh mesh;
  std::vector<std::uint32_t> vertices;
};

Part part_of(const TriangleMesh& mesh, const std::vector<std::uint8_t>& wanted) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  Part part;
  std::vector<std::uint32_t> index(mesh.vertices.size(), kNone);
  for (const auto& face : mesh.faces) {
    if (!std::all_of(face.begin(), face.end(), [&](std::uint32_t v) { return wanted[v] != 0; }))
      continue;
    TriangleMesh::Face own;
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& vertex = index[face[k]];
      if (vertex == kNone) {
        vertex = static_cast<std::uint32_t>(part.vertices.size());
        part.vertices.push_back(face[k]);
        part.mesh.vertices.push_back(mesh.vertices[face[k]]);
      }
      own[k] = vertex;
    }
    part.mesh.faces.push_back(own);
  }
  return part;
}

// The vertex nearest to a sample of a view that looks along `direction`.
std::optional<Sample> assign_to_vertex(const Eigen::Vector3d& point,
                                       const Eigen::Vector3d& direction, const TriangleMesh& mesh,
                                       const Part& part, const TriangleTree& tree, double reach) {
  const auto closest = tree.closest(point, reach);
  if (!closest) return std::nullopt;
  Eigen::Index corner = 0;
  closest->on_face.weights.maxCoeff(&corner);
  const std::uint32_t vertex =
      part.vertices[part.mesh.faces[closest->face][static_cast<std::size_t>(corner)]];
  const Eigen::Vector3d normal = mesh.normals[vertex].cast<double>();
  const Eigen::Vector3d away = point - closest->on_face.point;
  const double offset = away.dot(normal);
  if (!mesh.filled[vertex] || normal.dot(direction) >= 0.0 ||
      std::abs(offset) < kLeastCosine * away.norm())
    return std::nullopt;
  return Sample{vertex, offset, nearness(offset / reach)};
}

std::size_t wanted_faces(const TriangleMesh& mesh, const std::vector<std::uint8_t>& wanted) {
  return static_cast<std::size_t>(
      std::count_if(mesh.faces.begin(), mesh.faces.end(), [&](const auto& face) {
        return std::all_of(face.begin(), face.end(), [&](auto v) { return wanted[v] != 0; });
      }));
}

void add_samples_of(const ViewSampler& view, const TriangleMesh& mesh, const Part& part,
                    const TriangleTree& tree, double reach, std::vector<Sample>& samples) {
  std::vector<Eigen::Vector3d> points;
  view.for_scattered_samples([&](const Eigen::Vector3d& point) { points.push_back(point); });
  std::vector<std::optional<Sample>> found(points.size());
  constexpr std::size_t kAtOnce = 256;
  parallel_for(points.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      found[i] = assign_to_vertex(points[i], view.direction(), mesh, part, tree, reach);
  });
  for (const auto& sample : found)
    if (sample) samples.push_back(*sample);
}

}  // namespace

std::unordered_map<std::uint32_t, ScatteredSamples> scattered_samples_at(
    const TriangleMesh& mesh, const std::vector<std::uint8_t>& wanted,
    const std::vector<ViewSampler>& views, double reach, MemoryLimit* memory) {
  std::unordered_map<std::uint32_t, ScatteredSamples> found;
  const std::size_t faces = wanted_faces(mesh, wanted);
  if (faces == 0 || !make_room(memory, kFace * faces)) return found;
  const Part part = part_of(mesh, wanted);
  const TriangleTree tree(part.mesh);
  std::vector<Sample> samples;
  for (const ViewSampler& view : views) add_samples_of(view, mesh, part, tree, reach, samples);
  std::sort(samples.begin(), samples.end());
  for (const Sample& sample : samples) {
    ScatteredSamples& at = found[sample.vertex];
    at.offset += sample.weight * sample.offset;
    at.weight += sample.weight;
  }
  std::erase_if(found, [](const auto& entry) { return !(entry.second.weight > 0.0); });
  for (auto& [vertex, at] : found) at.offset /= at.weight;
  return found;
}

}  // namespace relief::fusion
