#include "fusion/holes/scattered_samples.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <tuple>

#include <Eigen/Core>

#include "fusion/tsdf/tsdf_integration.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"
#include "scan/mesh/triangle_tree.h"

namespace relief::fusion {

namespace {

// A sample tells of the surface that it lies over: the way to it is within 60 degrees of the
// normal. Beyond the rim of what is wanted, and over the other side of an edge, it is not.
constexpr double kLeastCosine = 0.5;

struct ScatteredPoint {
  Eigen::Vector3d point, direction;  // Of the view: where it looks.
};

struct Sample {
  std::uint32_t vertex;
  double offset, weight;
  bool operator<(const Sample& other) const {
    return std::tie(vertex, offset, weight) < std::tie(other.vertex, other.offset, other.weight);
  }
};

std::vector<ScatteredPoint> scattered_points(const std::vector<ViewSampler>& views) {
  std::vector<ScatteredPoint> points;
  for (const ViewSampler& view : views) {
    const Eigen::Vector3d direction = view.direction();
    view.for_scattered_samples([&](const Eigen::Vector3d& point) {
      points.push_back({point, direction});
    });
  }
  return points;
}

// The mesh with the wanted faces alone.
TriangleMesh wanted_part(const TriangleMesh& mesh, std::span<const std::uint8_t> wanted) {
  TriangleMesh part;
  part.vertices = paged_copy(mesh.vertices);
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    const auto& face = mesh.faces[f];
    if (std::all_of(face.begin(), face.end(), [&](std::uint32_t v) { return wanted[v] != 0; }))
      part.faces.push_back(face);
  });
  return part;
}

// The vertex of the mesh nearest to a sample, by a tree over a part of its faces.
std::optional<Sample> assign_to_vertex(const ScatteredPoint& sample, const TriangleMesh& mesh,
                                       const TriangleTree& tree, double reach) {
  const auto closest = tree.closest(sample.point, reach);
  if (!closest) return std::nullopt;
  Eigen::Index corner = 0;
  closest->on_face.weights.maxCoeff(&corner);
  const std::uint32_t vertex = tree.mesh().faces[closest->face][static_cast<std::size_t>(corner)];
  const Eigen::Vector3d normal = mesh.normals[vertex].cast<double>();
  const Eigen::Vector3d away = sample.point - closest->on_face.point;
  const double offset = away.dot(normal);
  if (!mesh.filled[vertex] || normal.dot(sample.direction) >= 0.0 ||
      std::abs(offset) < kLeastCosine * away.norm())
    return std::nullopt;
  return Sample{vertex, offset, tukey_biweight(offset / reach)};
}

}  // namespace

std::unordered_map<std::uint32_t, ScatteredSamples> scattered_samples_at(
    const TriangleMesh& mesh, std::span<const std::uint8_t> wanted,
    const std::vector<ViewSampler>& views, double reach) {
  std::unordered_map<std::uint32_t, ScatteredSamples> found;
  const std::vector<ScatteredPoint> points = scattered_points(views);
  if (points.empty()) return found;
  const TriangleMesh part = wanted_part(mesh, wanted);
  if (part.faces.empty()) return found;
  const TriangleTree tree(part);
  std::vector<std::optional<Sample>> assigned(points.size());
  constexpr std::size_t kAtOnce = 256;
  parallel_for(points.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      assigned[i] = assign_to_vertex(points[i], mesh, tree, reach);
  });
  std::vector<Sample> samples;
  for (const auto& sample : assigned)
    if (sample) samples.push_back(*sample);
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
