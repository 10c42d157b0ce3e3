#pragma once

#include <vector>

#include "fusion/surface/vertex_attributes.h"
#include "fusion/views/view_sampler.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

/// Sets `colours` of a merged mesh whose `filled` and `normals` are set: to the mean over the views
/// that measured the vertex and have colours, by the weights of their distances. Other vertices
/// continue the colours around them smoothly; where there are none within reach they are black.
/// Leaves them empty when no view has colours.
void set_vertex_colours(TriangleMesh& mesh, const std::vector<ViewSampler>& views,
                        const VertexAttributeOptions& options);

}  // namespace relief::fusion
