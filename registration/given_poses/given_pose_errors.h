#pragma once

#include <optional>
#include <vector>

#include "registration/surface/view_surface.h"
#include "relief/registration/align_views.h"
#include "relief/scan/range_view.h"
#include "scan/views/pose_convention.h"

namespace relief::registration {

/// Whether refining moved most pairs of guesses to each other by more than guesses err, to where
/// views deviate by more than their noise: they may have come to rest anywhere. False where a pose
/// is known. `taken` is the convention in which the guesses were taken.
bool refinement_moved_far(const std::vector<RangeView>& views,
                          const std::vector<ViewSurface>& surfaces, const Alignment& alignment,
                          const PoseConvention& taken);

/// Whether more pairs of guesses leave motions free, or deviate by more than noise and sampling
/// explain, than determine all motions. Refining may have come to rest beside where views belong,
/// with walls on other walls; or the surface determines no more. False where a pose is known.
bool has_few_determined_pairs(const std::vector<RangeView>& views, const Alignment& alignment);

/// Whether three views or more are verified, and pairs deviate by less than half of before, or
/// twice as many of them determine all motions.
bool fits_far_better(const std::vector<ViewSurface>& surfaces, const Alignment& now,
                     const Alignment& before);

/// The convention in which the guesses agree with the verified poses of an alignment: these show
/// that all guesses err alike (calibrate_hand_eye()). Nothing where they do not, where guesses err
/// by less than a sample spacing, where all are verified, and where a pose is known.
std::optional<PoseConvention> agreeing_convention(const std::vector<RangeView>& views,
                                                  const std::vector<ViewSurface>& surfaces,
                                                  const Alignment& alignment,
                                                  const PoseConvention& taken);

}  // namespace relief::registration
