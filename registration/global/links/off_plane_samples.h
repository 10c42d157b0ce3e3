#pragma once

#include "registration/global/features/planar_view.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

enum class OffPlaneVerdict {
  kConfirmed,  ///< Nearly all that either view should see of the other is there.
  kUnknown,    ///< There is too little of it, some is not there, or a view has no projection.
  kDenied,     ///< Most of what one view should see of the other is not there.
};

/// What the samples off the flat faces of two views say of a pose. Faces alone fit wherever they
/// meet at equal angles.
OffPlaneVerdict judge_off_plane_samples(const ViewSurface& a, const FlatFaces& a_faces,
                                        const ViewSurface& b, const FlatFaces& b_faces,
                                        const RigidMotion& b_from_a, double min_stddev = 0.0);

}  // namespace relief::registration
