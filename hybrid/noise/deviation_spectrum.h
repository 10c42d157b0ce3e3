#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "hybrid/model/range_steps.h"
#include "relief/hybrid/refine_view.h"

namespace relief::hybrid {

/// How far ranges deviate from the surface that normals imply, by wavelength, before and after
/// samples moved (H17). `steps`: of the measured ranges, with the normals they are compared with.
/// `moved`: by how much each sample moved along its ray [unit], of the same grid; 0 elsewhere.
std::vector<DeviationBand> deviation_spectrum(const RangeSteps& steps, const Grid<float>& moved);

}  // namespace relief::hybrid
