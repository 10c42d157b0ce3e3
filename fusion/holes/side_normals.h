#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <Eigen/Core>

#include "fusion/holes/plates/thin_plate.h"
#include "relief/scan/page_allocator.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

/// Normals of what was measured and of what was filled, near the border between them, each averaged
/// over some rings of vertices of its own side: the border itself is too ragged to tell how the two
/// meet.
class SideNormals {
 public:
  /// Edges from a vertex to those that its normal depends on: it is averaged over so many rings.
  static constexpr int kReach = 4;

  /// Of faces with a vertex that has `wanted` set.
  SideNormals(const TriangleMesh& mesh, std::span<const std::uint8_t> wanted);

  /// Of one vertex, of length 1; zero where it is unknown.
  Eigen::Vector3d at(std::uint32_t vertex) const;

  /// Cosine of the angle between the two sides at a measured vertex beside filled ones; 1 where it
  /// cannot be told.
  double cosine(std::uint32_t vertex, const FacesAround& around) const;

 private:
  static constexpr std::uint32_t kUnknown = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t place_of(std::uint32_t vertex) const;  // In vertices_, or kUnknown.
  void average();

  const TriangleMesh& mesh_;
  PagedVector<std::uint32_t> vertices_;                // That have a normal, sorted.
  PagedVector<std::array<std::uint32_t, 3>> corners_;  // Of the wanted faces, by place_of().
  PagedVector<Eigen::Vector3d> normals_;
};

}  // namespace relief::fusion
