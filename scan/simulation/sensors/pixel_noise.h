#pragma once

#include "relief/scan/grid.h"
#include "scan/simulation/base/random_stream.h"

namespace relief::simulation {

/// Gaussian noise of mean 0 and variance 1 at each pixel, correlated between pixels: white noise
/// smoothed by a Gaussian kernel. The correlation of two pixels is exp(-(distance / length)^2) with
/// `correlation` [pixels] for length, to a few percent for lengths of 1.5 and more; below 0.5 the
/// noise is white. The numbers are as random at the border as inside.
Grid<double> pixel_noise(int width, int height, double correlation, const RandomStream& random);

}  // namespace relief::simulation
