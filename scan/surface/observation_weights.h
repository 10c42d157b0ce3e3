#pragma once

#include <Eigen/Core>

#include "relief/scan/discontinuities.h"
#include "relief/scan/grid.h"
#include "relief/scan/range_view.h"
#include "scan/grid/connected_grid.h"

namespace relief {

struct ObservationWeightOptions {
  int silhouette_ramp = 6;  ///< The weight grows from the silhouette over this many pixels.
  /// Deviation that gives a sample the weight of confidence 1 [unit]; the same for all views. 0:
  /// deviations are ignored.
  double nominal_deviation = 0.0;
};

/// The ramp of the weight, > 0 and at most 1, so many pixels from the silhouette: samples beside it
/// are the least accurate, since the spot of the sensor lies on both sides.
double silhouette_weight(double boundary_distance, int ramp);

/// What each sample counts for where several views are averaged (Turk and Levoy 1994): confidence x
/// cosine of the viewing angle x ramp from the silhouette. Where a sample's deviation is known,
/// (nominal deviation / deviation along the normal)^2 takes the place of the confidence; a
/// confidence of zero stays. `normals` are unit, in the view frame. Zero where there is no sample
/// or no normal.
Grid<float> observation_weights(const RangeView& view, const ConnectedGrid& grid,
                                const Grid<Eigen::Vector3f>& normals,
                                const ObservationWeightOptions& options);

}  // namespace relief
