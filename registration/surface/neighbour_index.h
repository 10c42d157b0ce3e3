#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

namespace relief::registration {

/// Exact nearest neighbours among a fixed set of points (a FLANN kd-tree). Points are stored in
/// single precision relative to their centre, so that the position of the set costs no precision.
class NeighbourIndex {
 public:
  /// Columns are points; at least one.
  explicit NeighbourIndex(const Eigen::Matrix3Xd& points);
  ~NeighbourIndex();
  NeighbourIndex(NeighbourIndex&&) noexcept;
  NeighbourIndex& operator=(NeighbourIndex&&) noexcept;

  /// For each column the index of the closest point. Safe to call from several threads.
  std::vector<int> nearest(const Eigen::Matrix3Xd& queries) const;

  /// For each point of the set the others within `radius` [unit] of it, by ascending index. Single
  /// precision: those within a millionth of the set's size of the radius may be missing or too
  /// many.
  std::vector<std::vector<int>> neighbours_within(double radius) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace relief::registration
