#pragma once

#include <Eigen/Core>

#include "relief/scan/discontinuities.h"
#include "relief/scan/range_view.h"
#include "scan/grid/connected_grid.h"
#include "scan/grid/range_noise.h"

namespace relief::registration {

/// Standard deviation of the white noise of positions along the normal [unit], robustly from third
/// differences of the range along rows and columns; 0 where there are none.
double position_noise(const RangeView& view, const ConnectedGrid& grid, const RangeNoise& noise);

/// Standard deviation of the slope of a plane [rad] that is fitted to a square window of half width
/// `radius` [pixels] of samples with that noise.
double slope_noise(double noise, double spacing, int radius);

/// The root mean square of the noise over the view, relative to that of a typical sample; >= 1.
/// Samples with more than kLargestNoiseRatio times the typical noise are left out.
double noise_ratio(const RangeView& view, const RangeNoise& noise);

/// How much of a step along the ray a surface moves along its normal: the median over samples.
double typical_incidence(const RangeView& view, const Grid<Eigen::Vector3f>& normals);

/// The step of the ranges along the rays [unit], root mean square over the samples but those with
/// more than kLargestNoiseRatio times the typical one; 0 where they are not rounded.
double typical_step(const RangeView& view, const RangeNoise& noise);

}  // namespace relief::registration
