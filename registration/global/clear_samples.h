#pragma once

#include "registration/global/features/planar_view.h"
#include "registration/surface/view_surface.h"
#include "relief/scan/rigid_motion.h"

namespace relief::registration {

/// What samples of one view that stand clear of its flat faces meet in another view.
struct ClearSamples {
  int seen = 0;    ///< In front of the other's surface, on it or little behind it.
  int met = 0;     ///< Of these on it, with a similar normal.
  int beside = 0;  ///< Of these where it stands clear of the other's faces, too.
};

/// Nothing where the target has no projection.
ClearSamples find_clear_samples(const ViewSurface& source, const FlatFaces& source_faces,
                                const ViewSurface& target, const FlatFaces& target_faces,
                                const RigidMotion& target_from_source, double min_stddev);

enum class ClearVerdict {
  kConfirmed,  ///< Nearly all that either view should see of the other is there.
  kUnknown,    ///< There is too little of it, or some is not there.
  kDenied,     ///< Most of what one view should see of the other is not there.
};

/// What the samples that stand clear of the flat faces of two views say of a pose. Faces alone fit
/// wherever they meet at equal angles.
ClearVerdict judge_clear_of_faces(const ViewSurface& a, const FlatFaces& a_faces,
                                  const ViewSurface& b, const FlatFaces& b_faces,
                                  const RigidMotion& b_from_a, double min_stddev = 0.0);

}  // namespace relief::registration
