#pragma once

#include <cstddef>
#include <vector>

#include "registration/calibration/corrected_views.h"
#include "registration/calibration/pairwise_fit.h"
#include "registration/posegraph/view_graph.h"
#include "relief/registration/align_views.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The last steps of aligning, with all samples of the corrected views, from the poses `start` on:
/// the alignment of the views as given with the poses that follow. The deviations of poses are
/// multiplied by `inflation`, which the errors of the sensors make of them.
Result<Alignment> align_corrected(const CorrectedViews& views, const Alignment& given,
                                  const std::vector<RigidMotion>& start,
                                  const std::vector<RigidTangent>& inflation);

/// align_views() of the corrected views, from the poses that they were given with, shape search
/// included. Deviations as above.
Result<Alignment> align_from_given(const CorrectedViews& views, const Alignment& given,
                                   const std::vector<RigidTangent>& inflation,
                                   const Progress& progress);

/// Whether aligning the corrected views from the poses that they were given with may give more than
/// `corrected`, which starts from the poses of the alignment `given`: there not all views were
/// verified, or the corrected views fit as well at the poses that they were given with.
bool may_gain_from_given(const CorrectedViews& views, const Alignment& given,
                         const Alignment& corrected);

std::size_t aligned_views(const Alignment& alignment);

/// How well the views fit each other with the errors that are taken out, at such poses.
PairwiseFit fit_of(const CorrectedViews& views, const std::vector<RigidMotion>& world_from_view,
                   const std::vector<ViewPair>& pairs);

/// Whether views fit each other better than before by the same measure: distances along the lines
/// of sight, which no motion of the surfaces makes shorter by turning them away, and overlap that
/// stays.
bool fits_better(const PairwiseFit& now, const PairwiseFit& before);

}  // namespace relief::registration
