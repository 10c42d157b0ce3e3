#include "registration/verification/shared_surface.h"

namespace relief::registration {

SharedSurface::SharedSurface(const RigidMotion& b_from_a, const Correspondences& in_b,
                             const Correspondences& in_a) {
  for (const Correspondence& c : in_b.items) {
    points.push_back({c.target.point, c.target.normal});
    normals.push_back(b_from_a.linear() * c.source.normal);
  }
  for (const Correspondence& c : in_a.items) {
    points.push_back({b_from_a * c.target.point, b_from_a.linear() * c.target.normal});
    normals.push_back(c.source.normal);
  }
}

}  // namespace relief::registration
