#pragma once

#include "registration/global/pair_search.h"
#include "registration/surface/view_surface.h"

namespace relief::registration {

/// Whether the relief that both views show leaves a motion between them undetermined: the one of
/// shared_constraints(). PoseEvidence::degenerate tells it of either view's normals alone, and
/// takes noise that neighbouring samples share, or a feature of one view, for a constraint.
///
/// True where the views share next to nothing along that motion. Where they share little, one view
/// is moved along it by 0.15 of its radius, either way, and fitted again: true if it stays there
/// and fits as well.
bool lacks_shared_constraint(const ViewSurface& a, const ViewSurface& b, const PoseHypothesis& pose,
                             const CoarseScale& scale, const JudgeOptions& judge);

}  // namespace relief::registration
