#pragma once

#include <Eigen/Core>

#include "registration/global/features/resampled_view.h"

namespace relief::registration {

/// One column of numbers per point that describe the shape of the surface around it and do not
/// change when the view moves.
using LocalFeatures = Eigen::MatrixXf;

/// Fast point feature histograms (Rusu et al. 2009) of the points of `view` at two radii [unit],
/// each of length 1. Bins are finer about zero, where smooth objects have most of their angles.
LocalFeatures compute_fpfh(const ResampledView& view, double small_radius, double large_radius);

}  // namespace relief::registration
