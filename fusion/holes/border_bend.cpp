#include "fusion/holes/border_bend.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace relief::fusion {

namespace {

// Of that angle: a sphere of which less than a thirtieth was seen is none that anybody knows.
constexpr double kLeastSine = 0.25;

// Mean distance of a border from its centre [unit].
double half_width(const FairRegion& region) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const PlateVertex& held : region.border) centre += held.place;
  centre /= static_cast<double>(region.border.size());
  double sum = 0.0;
  for (const PlateVertex& held : region.border) sum += (held.place - centre).norm();
  return sum / static_cast<double>(region.border.size());
}

// The vertices beside those of a ring that are one edge farther from what was filled.
std::vector<std::uint32_t> ring_beyond(const MeshRings& of,
                                       const std::vector<std::uint32_t>& ring) {
  std::vector<std::uint32_t> next;
  for (const std::uint32_t v : ring)
    of.around.visit(v, [&](std::uint32_t f) {
      for (const std::uint32_t w : of.mesh.faces[f])
        if (of.rings[w] == of.rings[v] + 1) next.push_back(w);
    });
  std::sort(next.begin(), next.end());
  next.erase(std::unique(next.begin(), next.end()), next.end());
  return next;
}

}  // namespace

double behind_border(const TriangleMesh& mesh, const FairRegion& region) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const PlateVertex& free : region.vertices) centre += mesh.vertices[free.vertex];
  centre /= static_cast<double>(region.vertices.size());
  double behind = 0.0, away = 0.0;
  for (const PlateVertex& held : region.border) {
    const Eigen::Vector3d to_centre = centre - held.place;
    behind -= to_centre.dot(mesh.normals[held.vertex].cast<double>());
    away += to_centre.norm();
  }
  return behind / away;
}

BorderBend bend_at_border(const MeshRings& of, const FairRegion& region, double voxel) {
  BorderBend bend;
  double area = 0.0;  // Of the filled faces, six times.
  for (const PlateVertex& free : region.vertices) {
    if (!of.mesh.filled[free.vertex]) continue;
    of.around.visit(free.vertex, [&](std::uint32_t f) {
      bend.facing += face_cross(of.mesh, f);
      area += face_cross(of.mesh, f).norm();
    });
  }
  bend.facing.normalize();
  const auto mean_turn = [&](const std::vector<std::uint32_t>& ring) {
    double sum = 0.0;
    for (const std::uint32_t v : ring)
      sum += std::acos(std::clamp(of.mesh.normals[v].cast<double>().dot(bend.facing), -1.0, 1.0));
    return sum / static_cast<double>(ring.size());
  };
  std::vector<std::uint32_t> ring;
  for (const PlateVertex& held : region.border) ring.push_back(held.vertex);
  bend.turn = mean_turn(ring);
  for (int k = 0; k < kApproachRings && !ring.empty(); ++k) ring = ring_beyond(of, ring);
  if (ring.empty()) return bend;
  const double rate = (mean_turn(ring) - bend.turn) / (kApproachRings * voxel);
  const double half_way = std::sqrt(area / (6.0 * std::numbers::pi));
  bend.carried = rate * half_way;  // Equation (F8).
  bend.on_sphere = rate * std::min(half_way, half_width(region)) * bend.turn /
                   std::max(std::sin(bend.turn), kLeastSine);
  bend.known = true;
  return bend;
}

void add_approach(const MeshRings& of, FairRegion& region) {
  std::vector<std::uint32_t> ring;
  for (const PlateVertex& held : region.border) ring.push_back(held.vertex);
  for (int k = 1; k < kApproachRings; ++k) {
    ring = ring_beyond(of, ring);
    region.approach.insert(region.approach.end(), ring.begin(), ring.end());
  }
}

}  // namespace relief::fusion
