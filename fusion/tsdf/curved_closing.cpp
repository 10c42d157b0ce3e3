#include "fusion/tsdf/curved_closing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "fusion/holes/bent_regions.h"
#include "fusion/surface/isosurface.h"
#include "fusion/surface/vertex_attributes.h"
#include "scan/base/parallel.h"
#include "scan/mesh/triangle_tree.h"

namespace relief::fusion {

namespace {

// A cell's diagonal, sqrt(3), is how far the nodes of a cell that the surface passes through can
// be from it.
constexpr double kHeld = 1.75;  // [spacings]

// Where no vertex moved farther the surface is where the field has it.
constexpr double kAtRest = 0.5;  // [spacings]

// Vertices of edges with one face: the zero set goes on in blocks that are not active.
void hold_open_border(TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& face : mesh.faces)
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(std::minmax({face[k], face[(k + 1) % 3]}));
  std::sort(edges.begin(), edges.end());
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const bool twice =
        (e > 0 && edges[e - 1] == edges[e]) || (e + 1 < edges.size() && edges[e + 1] == edges[e]);
    if (!twice) mesh.filled[edges[e].first] = mesh.filled[edges[e].second] = 0;
  }
}

struct HeldNode {
  std::size_t node;
  float value;
};

// The nodes of a block beside the surface that nobody measured, at their distance from it.
std::vector<HeldNode> beside(const SparseField& field, std::size_t b, const TriangleTree& tree,
                             const TriangleMesh& surface,
                             std::span<const NodeConstraint> constraints) {
  const double reach = kHeld * field.lattice().spacing;
  const double half = 0.5 * kBlockSide * field.lattice().spacing;
  const Eigen::Vector3d middle = field.lattice().position(field.first_node(b)) +
                                 Eigen::Vector3d::Constant(half - 0.5 * field.lattice().spacing);
  std::vector<HeldNode> held;
  if (!tree.closest(middle, reach + std::sqrt(3.0) * half)) return held;
  for (int i = 0; i < kBlockNodes; ++i) {
    const std::size_t node = b * kBlockNodes + static_cast<std::size_t>(i);
    if (constraints[node].fixed()) continue;
    const Eigen::Vector3d point = field.lattice().position(field.first_node(b) + node_at_offset(i));
    const auto closest = tree.closest(point, reach);
    if (!closest) continue;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      normal +=
          closest->on_face.weights(k) *
          surface.normals[surface.faces[closest->face][static_cast<std::size_t>(k)]].cast<double>();
    const bool outside = normal.dot(point - closest->on_face.point) > 0.0;
    const auto distance = static_cast<float>(outside ? closest->distance : -closest->distance);
    held.push_back({node, std::max(distance, constraints[node].floor)});
  }
  return held;
}

std::vector<HeldNode> beside_moved(const SparseField& field, BentRegions bent,
                                   std::span<const NodeConstraint> constraints) {
  TriangleMesh& surface = bent.mesh;
  std::erase_if(surface.faces, [&](const auto& face) {
    return std::none_of(face.begin(), face.end(), [&](auto v) { return bent.moved[v] != 0; });
  });
  const TriangleTree tree(surface);
  const auto of_blocks =
      parallel_map<std::vector<HeldNode>>(field.block_count(), [&](std::size_t b) {
        return field.active(b) ? beside(field, b, tree, surface, constraints)
                               : std::vector<HeldNode>();
      });
  std::vector<HeldNode> all;
  for (const auto& held : of_blocks) all.insert(all.end(), held.begin(), held.end());
  return all;
}

}  // namespace

bool close_curved(SparseField& field, const std::vector<ViewSampler>& views,
                  std::span<NodeConstraint> constraints, const CurvedClosingOptions& options,
                  const std::function<void()>& solve) {
  if (!seen_from_one_side(views)) return false;
  const double spacing = field.lattice().spacing;
  std::vector<std::pair<std::size_t, NodeConstraint>> before;
  for (int round = 0; round < options.rounds; ++round) {
    TriangleMesh mesh = extract_isosurface(field, options.memory);
    set_vertex_attributes(
        mesh, views,
        {.truncation = options.truncation, .voxel_size = spacing, .memory = options.memory});
    hold_open_border(mesh);
    FairFillOptions fair{options.truncation, spacing, options.memory};
    fair.most_bent = fair.most_solved = options.most_vertices;
    BentRegions bent = bend_filled_regions(std::move(mesh), views, fair);
    if (bent.farthest < kAtRest * spacing) return !before.empty();
    for (const auto& [node, constraint] : before) constraints[node] = constraint;
    before.clear();
    for (const auto& [node, value] : beside_moved(field, std::move(bent), constraints)) {
      before.emplace_back(node, constraints[node]);
      constraints[node] = kFixedNode;
      field.values(node / kBlockNodes)[node % kBlockNodes] = value;
    }
    solve();
  }
  return !before.empty();
}

}  // namespace relief::fusion
