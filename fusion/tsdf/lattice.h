#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>

#include "scan/base/cell_key.h"

namespace relief::fusion {

/// Integer coordinates of a lattice node.
using Node = Eigen::Vector3i;

/// A cubic lattice of the world frame: node n lies at origin + spacing n.
struct Lattice {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double spacing = 0.0;  ///< [unit]

  Eigen::Vector3d position(const Node& node) const {
    return origin + spacing * node.cast<double>();
  }
  /// Fractional lattice coordinates of a point.
  Eigen::Vector3d coordinates(const Eigen::Vector3d& point) const {
    return (point - origin) / spacing;
  }
};

/// Three coordinates of -2^20 to 2^20 - 1 in one integer that orders by z, then y, then x.
using NodeKey = std::uint64_t;
inline constexpr int kKeyOffset = 1 << 20;

inline NodeKey key_of(const Node& node) {
  return cell_key(node.x() + kKeyOffset, node.y() + kKeyOffset, node.z() + kKeyOffset);
}

inline Node node_of(NodeKey key) {
  const auto coordinate = [](NodeKey bits) {
    return static_cast<int>(bits & 0x1fffffu) - kKeyOffset;
  };
  return {coordinate(key), coordinate(key >> 21), coordinate(key >> 42)};
}

}  // namespace relief::fusion
