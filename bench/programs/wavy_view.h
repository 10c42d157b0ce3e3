#pragma once

#include "hybrid/model/view_problem.h"
#include "relief/scan/range_view.h"

namespace relief {

/// Of wavy views: standard deviations of a range [unit] and of a normal's slope [rad].
inline constexpr double kWavyRangeNoise = 0.3, kWavyNormalNoise = 0.026;

/// An orthographic view of side x side samples, one unit apart, of waves with slopes up to about a
/// half, with noise and a smooth bias of the normals.
RangeView wavy_view(int side);

/// The weights of (H5) in such a view: its range noise, and standard deviations of a normal's slope
/// and of the bias from sample to sample [rad].
hybrid::ViewWeights wavy_weights(const hybrid::ViewProblem& problem, double sigma_normal,
                                 double sigma_bias_step);

}  // namespace relief
