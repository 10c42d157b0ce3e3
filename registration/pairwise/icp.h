#pragma once

#include "registration/surface/view_surface.h"
#include "relief/registration/align_pair.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// The same as align_pair() of two views, with surfaces prepared once for several pairs.
IcpResult align_pair(const ViewSurface& source, const ViewSurface& target,
                     const RigidMotion& target_from_source, const IcpOptions& options = {});

}  // namespace relief::registration
