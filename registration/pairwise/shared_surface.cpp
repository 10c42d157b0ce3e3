#include "registration/pairwise/shared_surface.h"

namespace relief::registration {

SharedSurface::SharedSurface(const RigidMotion& frame_from_a, const RigidMotion& frame_from_b,
                             const Correspondences& in_b, const Correspondences& in_a) {
  const auto append = [this](const Correspondences& found, const RigidMotion& frame_from_source,
                             const RigidMotion& frame_from_target) {
    for (const Correspondence& c : found.items) {
      points.push_back(
          {frame_from_target * c.target.point, frame_from_target.linear() * c.target.normal});
      normals.push_back(frame_from_source.linear() * c.source.normal);
    }
  };
  append(in_b, frame_from_a, frame_from_b);
  append(in_a, frame_from_b, frame_from_a);
}

}  // namespace relief::registration
