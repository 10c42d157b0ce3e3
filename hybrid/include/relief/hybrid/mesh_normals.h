#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::hybrid {

/// The normals that views measured at the vertices of a mesh. All vectors have an entry a vertex.
struct MeshNormals {
  std::vector<Eigen::Vector3f> normals;  ///< Unit, world frame; zero where no view has one.
  std::vector<float> sigma;  ///< Standard error of the slope along a tangent [rad]; 0 there.
  std::vector<std::uint16_t> views;  ///< How many views agreed on it.
  double sigma_view = 0.0;           ///< Scatter of one view's normals round the mean [rad].
  double sample_spacing = 0.0;       ///< Median of the views that have normals [unit].
  std::size_t measured = 0;          ///< Vertices that have a normal.
  /// At the middle of each edge, in the order of the neighbours of mesh_graph; zero where none, or
  /// empty when not asked for.
  std::vector<Eigen::Vector3f> edges;
};

struct MeshNormalOptions {
  /// A view measured a vertex if its surface passes it within this distance [unit]; 0: three
  /// sample spacings.
  double max_distance = 0.0;
  /// The weight of a sample grows from the view's silhouettes over this many pixels.
  int silhouette_ramp = 6;
  /// Scatter of one view's normals along a tangent [rad], > 0; 0: from how the views disagree, or
  /// 2 degrees where no vertex was seen by two views.
  double sigma_view = 0.0;
  bool edges = true;  ///< Also blend normals at the middles of edges.
};

/// Looks every vertex up in every view that sees it (its surface passes there, faces the vertex's
/// side of the mesh, and is connected round the pixel), interpolates the view's normals, and blends
/// them by confidence, viewing angle and distance to the silhouette; views that disagree with the
/// others lose their say. `mesh` and the views' `world_from_view` share one frame. Vertices marked
/// as filled get none, nor do views without normals or (unless it is the only one) without a pose
/// say anything. Errors: kUnsolvable for a view whose pixels cannot be found, kInterrupted.
Result<MeshNormals> vertex_normals_from_views(const TriangleMesh& mesh,
                                              const std::vector<RangeView>& views,
                                              const MeshNormalOptions& options = {},
                                              const Context& context = {});

}  // namespace relief::hybrid
