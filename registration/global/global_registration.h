#pragma once

#include <vector>

#include "registration/global/view_groups.h"
#include "registration/surface/view_surface.h"
#include "registration/units/align_units.h"
#include "registration/verification/pose_evidence.h"
#include "relief/registration/search_pairs.h"
#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

struct GlobalRegistrationOptions {
  Association association = Association::kAuto;
  VerificationThresholds limits;  ///< What links of views must show.
  /// Two ways of joining views are told apart when the weaker has less than this part of the
  /// support of the stronger; in (0, 1].
  double ambiguity = 0.5;
  /// Pairs of views that are searched, per view, at most; > 0. Bounds the time. Small sets are
  /// searched in full.
  int pairs_per_view = 12;
};

/// Joins groups of views that fit together by shape: pairs of similar views are searched for
/// relative poses until all views are in one group or no more pairs are worth it. `start`: views
/// whose poses are checked, in groups that stay together; the others alone. `known` views do not
/// move; they are in one group of `start`. Views without samples stay alone. The only error is
/// kInterrupted.
Result<ViewGroups> register_globally(const std::vector<ViewSurface>& surfaces,
                                     const ViewGroups& start, const std::vector<bool>& known,
                                     const GlobalRegistrationOptions& options = {},
                                     const Progress& progress = {}, const AlignUnits& units = {});

/// Computes units of work that register_globally() with the same arguments needs: a block of the
/// pairs of its first round, and whether every `block.count`th view fits itself. Returns how many
/// pairs that are. The only error is kInterrupted.
Result<std::size_t> search_first_pairs(const std::vector<ViewSurface>& surfaces,
                                       const ViewGroups& start, const std::vector<bool>& known,
                                       const GlobalRegistrationOptions& options,
                                       const PairBlock& block, const Progress& progress,
                                       const AlignUnits& units);

}  // namespace relief::registration
