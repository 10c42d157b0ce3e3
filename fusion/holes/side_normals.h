#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "fusion/holes/plates/thin_plate.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/base/memory/memory_limit.h"

namespace relief::fusion {

/// Normals of what was measured and of what was filled, near the border between them, each averaged
/// over some rings of vertices of its own side: the border itself is too ragged to tell how the two
/// meet.
class SideNormals {
 public:
  /// Edges from a vertex to those that its normal depends on: it is averaged over so many rings.
  static constexpr int kReach = 4;

  /// Of faces with a vertex that has `wanted` set. `memory` may be null; where it cannot be kept,
  /// which it tells, all normals are unknown.
  SideNormals(const TriangleMesh& mesh, std::span<const std::uint8_t> wanted, MemoryLimit* memory);

  /// Of one vertex, of length 1; zero where it is unknown.
  Eigen::Vector3d at(std::uint32_t vertex) const;

  /// Cosine of the angle between the two sides at a measured vertex beside filled ones; 1 where it
  /// cannot be told.
  double cosine(std::uint32_t vertex, const FacesAround& around) const;

 private:
  bool is_measured(std::uint32_t face) const;
  void average();

  const TriangleMesh& mesh_;
  std::vector<std::uint32_t> faces_;
  std::unordered_map<std::uint32_t, Eigen::Vector3d> normals_;
};

}  // namespace relief::fusion
