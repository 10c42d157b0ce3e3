#pragma once

#include "registration/global/pair_search.h"
#include "registration/surface/view_surface.h"

namespace relief::registration {

/// Whether two views could as well lie elsewhere along the motion that holds them least
/// (least_shared_constraint()), though noise that neighbouring samples share, or a feature of one
/// view alone, seems to hold them. So it is where they share no relief at all along that motion.
/// Where they share little, one view is moved along it by a seventh of its radius, either way, and
/// fitted again: they slide if they come to rest there, and fit as well.
bool could_slide(const ViewSurface& a, const ViewSurface& b, const PoseHypothesis& pose,
                 const CoarseScale& scale, const JudgeOptions& judge);

}  // namespace relief::registration
