#pragma once

#include <cstdint>
#include <vector>

#include "fusion/views/view_sampler.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::fusion {

struct VertexAttributeOptions {
  double truncation = 0.0;  ///< As used for the field [unit].
  double voxel_size = 0.0;  ///< As used for the field [unit].
  /// Of one view's positions along the normal, at the typical distance from its sensor [unit].
  double view_stddev = 0.0;
  /// If > 0, weights are inverse variances in units of its square [unit]: see
  /// ObservationWeightOptions.
  double nominal_deviation = 0.0;
  MemoryLimit* memory = nullptr;  ///< May be null.
  /// Of each of the views, as `source_views` of the mesh has them; none: the mesh has none.
  std::vector<std::uint16_t> view_indices{};
};

/// Sets `views`, `source_views`, `filled`, `quality` and `normals` of a merged mesh by asking the
/// views again at each vertex. A vertex is filled when no view that faces it measured it, or the
/// mean of those that did is more than half a voxel away. Its quality is then the distance along
/// the mesh to the nearest measured vertex; otherwise the standard error of the mean of the views.
void set_vertex_attributes(TriangleMesh& mesh, const std::vector<ViewSampler>& views,
                           const VertexAttributeOptions& options);

/// Sets the quality of filled vertices to the distance along the mesh to the nearest measured one.
void set_filled_quality(TriangleMesh& mesh);

}  // namespace relief::fusion
