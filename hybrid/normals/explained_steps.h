#pragma once

#include "relief/scan/discontinuities.h"
#include "relief/scan/range_view.h"

namespace relief::hybrid {

/// Connects neighbours whose step along the rays their normals explain: the rim of a surface turns
/// away from the sensor, and its last samples are steps that ranges alone take for occlusion edges.
/// A step is explained if it differs by at most three standard deviations from the one that the
/// mean of both normals asks for, equation (H4); `sigma` is that of a range [unit]. Other edges
/// stay as they are.
void connect_explained_steps(const RangeView& view, double sigma, GridEdges& edges);

}  // namespace relief::hybrid
