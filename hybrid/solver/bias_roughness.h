#pragma once

#include <vector>

#include <Eigen/Core>

#include "hybrid/model/view_problem.h"

namespace relief::hybrid {

/// How much faster than in most places the bias in the solution `y` changes from sample to sample
/// round each movable sample: the ratio r of equation (H18), >= 1, in the order of their pixels.
/// Empty without a bias, or where it does not change.
std::vector<float> bias_roughness(const ViewProblem& problem, const Eigen::VectorXd& y);

}  // namespace relief::hybrid
