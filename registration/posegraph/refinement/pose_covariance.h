#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "registration/posegraph/refinement/block_sandwich.h"
#include "registration/posegraph/refinement/pose_graph_problem.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The covariance of all poses (R12), A^-1 B A^-1, as tangents (rotation [rad], translation [unit])
/// about each view's own centre in world axes. Copies share what they are made of.
class PoseCovariance {
 public:
  PoseCovariance() = default;  ///< Zero.
  /// `information`: A, inverted. `scatter`: B. `centres`: of the views, relative to the centre of
  /// the tangents of both.
  PoseCovariance(PoseGraphProblem information, SymmetricBlocks scatter,
                 std::vector<Eigen::Vector3d> centres);
  /// The blocks of single views alone, about the centre of the tangents.
  PoseCovariance(std::vector<Matrix6d> of_views, std::vector<Eigen::Vector3d> centres);

  /// Of one pose; zero for held views.
  Matrix6d of(std::size_t view) const;
  /// Between the poses of two views: its rows are those of `a`. Of two views only where A was
  /// inverted as a whole.
  Matrix6d between(std::size_t a, std::size_t b) const;

 private:
  Matrix6d about_centre(std::size_t a, std::size_t b) const;

  struct Parts {
    std::optional<PoseGraphProblem> information;
    std::vector<Matrix6d> of_views;
    SymmetricBlocks scatter;
    std::vector<Eigen::Vector3d> centres;
  };
  std::shared_ptr<const Parts> parts_;
};

}  // namespace relief::registration
