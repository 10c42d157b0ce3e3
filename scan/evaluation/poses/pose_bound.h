#pragma once

#include <vector>

#include <Eigen/Core>

#include "relief/scan/range_view.h"

namespace relief::evaluation {

/// The Fisher information of all poses (6V x 6V, tangents (rotation [rad], translation [unit])
/// about `centre` in world axes) that range views with white noise carry about how they lie to each
/// other, whatever the surface is: its inverse, with the rows and columns of one view taken out,
/// is the Cramer-Rao bound of aligning them. Of a patch of the surface that views see with
/// precisions w_i of its position along the normal [1/unit^2 per area], an unknown height leaves
///   diag(w) - w w^T / sum(w)
/// and a motion of view i changes its distance by j = ((p - centre) x n, n).
/// `truth`: exact views with true normals at their true poses, of cameras that can project.
/// `sigma`: standard deviation of the noise along the rays [unit].
Eigen::MatrixXd pose_information(const std::vector<RangeView>& truth, double sigma,
                                 const Eigen::Vector3d& centre);

}  // namespace relief::evaluation
