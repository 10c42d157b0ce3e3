#pragma once

#include <cstddef>

#include "relief/scan/context.h"
#include "relief/scan/result.h"
#include "relief/scan/rigid_motion.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::evaluation {

struct MeshAlignmentOptions {
  /// Points of the result in the final fit, >= 100. Bounds the time.
  std::size_t samples = 20000;
  /// Also try starts all over the rotations, with the centroids in one place, not only the
  /// identity: for results whose frame is any other. Costs some seconds.
  bool any_start = true;
};

struct MeshAlignment {
  RigidMotion truth_from_result = RigidMotion::Identity();
  double median_distance = 0.0;  ///< Of the result's points to the truth after the motion [unit].
  int iterations = 0;            ///< Of the final fit.
  bool converged = false;        ///< The last step was negligible.
};

/// The rigid motion that brings a mesh onto the true one: point-to-plane ICP (Chen and Medioni
/// 1992) with exact closest points and Tukey weights, so that parts which only one mesh has do not
/// pull. A good fit has a small median distance; symmetric objects have several. The seed of the
/// context chooses the points. kBadInput when a mesh has no area.
Result<MeshAlignment> align_mesh(const TriangleMesh& result, const TriangleMesh& truth,
                                 const MeshAlignmentOptions& options = {},
                                 const Context& context = {});

}  // namespace relief::evaluation
