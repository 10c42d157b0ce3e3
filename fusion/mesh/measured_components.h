#pragma once

#include <cstddef>
#include <vector>

#include "fusion/views/view_sampler.h"
#include "relief/scan/triangle_mesh.h"
#include "scan/mesh/mesh_components.h"

namespace relief::fusion {

struct MeasuredComponents {
  std::size_t kept = 0;
  RemovedComponents removed;
  double removed_samples = 0.0;  ///< Of the samples on any component, the part on removed ones.
};

/// Keeps the component of a merged mesh that the most samples of the views lie on, and every other
/// one that holds more than a twentieth of them: stray samples are fewer. A sample lies on the
/// component of the nearest vertex within `reach` [unit]. The area of a component tells little: a
/// noisy far wall may have the largest one.
MeasuredComponents keep_measured_components(const std::vector<ViewSampler>& views, double reach,
                                            TriangleMesh& mesh);

}  // namespace relief::fusion
