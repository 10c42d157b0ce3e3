#pragma once

#include "registration/surface/view_surface.h"

namespace relief::registration {

/// The part of a view's samples, in [0, 1], that noise alone parts from at most `planes` planes,
/// found greedily, the largest first. A view of a box consists of three.
double planar_fraction(const ViewSurface& view, int planes);

/// Whether a view shows hardly more than flat faces: corners and edges of boxes and prisms, which
/// look alike wherever faces meet at equal angles.
bool is_mostly_planar(const ViewSurface& view);

}  // namespace relief::registration
