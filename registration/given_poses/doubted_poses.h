#pragma once

#include <vector>

#include "registration/surface/view_surface.h"
#include "relief/registration/align_views.h"
#include "relief/scan/range_view.h"
#include "scan/views/pose_convention.h"

namespace relief::registration {

// Reasons to doubt poses that fit. Each function makes views `unverified` that were `verified`, but
// for those of known poses, and leaves the poses as they are.

/// All views where refining had not settled: its last step still moved samples by more than they
/// are apart, and by more than poses err by. Where errors of ranges fill the distance within which
/// partners are looked for, steps lead anywhere, and views fit as well wherever they lead.
void doubt_unsettled_poses(const std::vector<RangeView>& views, Alignment& alignment);

/// Of several views those that no pair of the refinement has, as they share too few samples, and
/// those that kept all six motions.
void doubt_undetermined_poses(const std::vector<RangeView>& views, Alignment& alignment);

/// Views that keep their guess along a motion where guesses are off: refining moved them, or the
/// median view, by more than a sample spacing along other motions. The guesses are taken in
/// `convention`.
void doubt_kept_motions(const std::vector<RangeView>& views,
                        const std::vector<ViewSurface>& surfaces, const PoseConvention& convention,
                        Alignment& alignment);

/// Views that `found`, where they were found by shape, does not have at the same poses as others,
/// to a sample spacing. For where refining moved views far, to where they deviate by more than
/// their noise: they may have come to rest anywhere.
void doubt_what_shape_does_not_confirm(const std::vector<ViewSurface>& surfaces,
                                       const Alignment& found, Alignment& alignment);

/// The median standard deviation of the centres of views that can move [unit]; 0 where none can.
double median_deviation(const Alignment& alignment);

}  // namespace relief::registration
