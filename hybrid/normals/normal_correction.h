#pragma once

#include <Eigen/Core>

#include "hybrid/model/view_problem.h"
#include "relief/scan/discontinuities.h"
#include "relief/scan/range_view.h"

namespace relief::hybrid {

/// The measured normals less a slope error per movable sample, `bias` = [b_u; b_v] [rad]: normal to
/// the two tangents whose slopes against the measured normal are b_u and b_v. Other normals stay.
Grid<Eigen::Vector3f> subtract_bias(const RangeView& view, const ViewProblem& problem,
                                    const Eigen::VectorXd& bias);

struct TwoStepResult {
  Grid<Eigen::Vector3f> normals;  ///< Equation (H1).
  bool solved = false;            ///< False: the smoothing failed, normals are as measured.
};

/// Equation (H1) (Nehab et al. 2005, section 4.1): low frequencies of the measured surface's
/// normals, high frequencies of the measured normals. `scale` is the length of the smoothing kernel
/// (I + scale^2 L)^-1 in samples; it never reaches across edges that are not connected.
TwoStepResult two_step_correction(const RangeView& view, const GridEdges& edges,
                                  const ViewProblem& problem, double scale);

}  // namespace relief::hybrid
