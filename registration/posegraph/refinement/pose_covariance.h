#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "registration/posegraph/refinement/pose_graph_problem.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// A symmetric matrix of 6x6 blocks, most of them zero: those with row <= column.
using SymmetricBlocks = std::map<std::pair<std::size_t, std::size_t>, Matrix6d>;

/// The covariance of all poses (R12), A^-1 B A^-1, as tangents (rotation [rad], translation [unit])
/// about each view's own centre in world axes. Blocks are multiplied out when they are asked for;
/// copies share what they are made of.
class PoseCovariance {
 public:
  PoseCovariance() = default;  ///< Zero.
  /// `information`: A, inverted. `scatter`: B. `centres`: of the views, relative to the centre of
  /// the tangents of both.
  PoseCovariance(PoseGraphProblem information, SymmetricBlocks scatter,
                 std::vector<Eigen::Vector3d> centres);

  /// Of one pose; zero for held views.
  Matrix6d of(std::size_t view) const;
  /// Between the poses of two views: its rows are those of `a`.
  Matrix6d between(std::size_t a, std::size_t b) const;

 private:
  struct Parts {
    PoseGraphProblem information;
    SymmetricBlocks scatter;
    std::vector<Eigen::Vector3d> centres;
  };
  std::shared_ptr<const Parts> parts_;
};

}  // namespace relief::registration
