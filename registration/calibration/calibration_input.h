#pragma once

#include <cstddef>
#include <vector>

#include "registration/calibration/estimation/calibration_sums.h"
#include "registration/posegraph/view_graph.h"
#include "relief/registration/align_views.h"
#include "relief/scan/range_view.h"

namespace relief::registration {

/// The pairs that calibration uses: those of the largest overlaps of each view that are no misfits.
std::vector<ViewPair> fitting_pairs(const Alignment& aligned);

/// The gauge: known poses, views without pairs, and the first view of each group without a known
/// pose.
std::vector<bool> held_views(const std::vector<RangeView>& views,
                             const std::vector<ViewPair>& pairs);

/// Whether the shape of the pairs holds every view that has pairs.
bool shape_holds_all(const Alignment& aligned);

/// Which views have pairs.
std::vector<bool> linked_views(std::size_t views, const std::vector<ViewPair>& pairs);

/// Whether pairs can tell of errors of the sensors: at least three views have pairs, the system of
/// the errors that views share is not too large (2500 terms of all sensors), and shape_holds_all().
bool can_see_sensor_errors(const Alignment& aligned, const std::vector<ViewPair>& pairs,
                           const Sensors& sensors);

/// Whether can_see_sensor_errors() holds, and at most 200 views have pairs.
bool can_be_calibrated(const Alignment& aligned, const std::vector<ViewPair>& pairs,
                       const Sensors& sensors);

/// Whether the errors of single views may be estimated: of at most 1000 terms of all views, those
/// of 40 pinhole cameras.
bool may_err_apart(const Sensors& sensors);

/// The median over the pairs of the robust deviations of their distances, those of 0 left out.
double median_deviation(const std::vector<PairSums>& sums);
double median_deviation(std::vector<double> deviations);

std::vector<const RangeView*> pointers_to(const std::vector<RangeView>& views);

/// All that a surface without normal maps is made of.
RangeView ranges_of(const RangeView& view);

}  // namespace relief::registration
