#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "relief/scan/context.h"
#include "relief/scan/page_allocator.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::hybrid {

/// The normals that views measured at the vertices of a mesh. All vectors have an entry a vertex.
struct MeshNormals {
  PagedVector<Eigen::Vector3f> normals;  ///< Unit, world frame; zero where no view has one.
  PagedVector<float> sigma;  ///< Standard error of the slope along a tangent [rad]; 0 there.
  PagedVector<std::uint16_t> views;  ///< How many views agreed on it.
  double sigma_view = 0.0;           ///< Scatter of one view's normals round the mean [rad].
  double sample_spacing = 0.0;       ///< Median of the views that have normals [unit].
  std::size_t measured = 0;          ///< Vertices that have a normal.
  /// At the middle of each edge, in the order of the neighbours of mesh_graph; zero where none, or
  /// empty when not asked for.
  PagedVector<Eigen::Vector3f> edges;
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

/// How the vertices of a mesh may move.
enum class MeshForm {
  kAlongNormals,  ///< Along the vertex normals of the mesh: one unknown a vertex.
  kFull,          ///< In space: equation (H13) in full.
};

struct PolishOptions {
  MeshForm form = MeshForm::kAlongNormals;
  /// Standard deviation of a vertex along its normal [unit], > 0. Default: `quality` of the mesh.
  std::optional<double> sigma_position;
  /// Standard deviation of a blended normal's slope along one tangent [rad], > 0. Default: that of
  /// the blend.
  std::optional<double> sigma_normal;
  /// kFull: standard deviation of a vertex along the surface over that along its normal, > 0.
  double tangential = 1.0;
  /// Rounds of robust reweighting that follow the plain least-squares solve, at most; 0: none. They
  /// end when one moves the surface by little.
  int robust_rounds = 3;
  /// Of conjugate gradients, relative: leaves 0.002 expected errors RMS (docs/hybrid.md, Options).
  double tolerance = 1e-3;
  int max_iterations = 500;   ///< Of conjugate gradients, per solve.
  MeshNormalOptions normals;  ///< How views are blended.
};

enum class PolishStatus {
  kPolished,
  kNoNormals,           ///< No two neighbouring vertices have a normal: the mesh is as given.
  kMissingUncertainty,  ///< Neither a mesh with `quality` nor `sigma_position`: the mesh is as
                        ///< given.
  kNotConverged,        ///< The solver gave up: the mesh is its last iterate, better than as given.
};
std::string_view to_string(PolishStatus status);

/// What polishing did to a mesh.
struct PolishSummary {
  PolishStatus status = PolishStatus::kPolished;
  std::size_t with_normal = 0;  ///< Vertices that have a blended normal.
  double sigma_view = 0.0;      ///< Scatter of one view's normals [rad]; 0 if unknown.
  double rms_move = 0.0;        ///< Of the vertices that have a normal [unit].
  double max_move = 0.0;        ///< Of all vertices [unit].
  std::size_t damped = 0;       ///< Vertices held back so that no face flips or degenerates.
  std::size_t unmoved = 0;      ///< Of these, the ones that did not move at all.
  int rounds = 0;               ///< Linear systems solved.
  int iterations = 0;           ///< Steps of conjugate gradients, all rounds together.
  double seconds = 0.0;
};

struct PolishedMesh : PolishSummary {
  /// Vertices moved and normals renewed; all else as given: `quality` stays the expected error
  /// before polishing, which polishing lowers.
  TriangleMesh mesh;
};

/// Refines a merged mesh with the normals that `views` measured (Nehab et al. 2005, section 4.3;
/// equations (H13) and (H14)): the faces stay, the vertices move as far as no face flips or
/// degenerates. Vertices that no normal tells about move smoothly with those around them. Errors:
/// kBadInput for an option out of range or a mesh whose attributes do not fit it; kUnsolvable for a
/// view whose pixels cannot be found; kInterrupted.
Result<PolishedMesh> polish_mesh(const TriangleMesh& mesh, const std::vector<RangeView>& views,
                                 const PolishOptions& options = {}, const Context& context = {});

/// The same with given normals.
Result<PolishedMesh> polish_mesh(const TriangleMesh& mesh, MeshNormals normals,
                                 const PolishOptions& options = {}, const Context& context = {});

}  // namespace relief::hybrid
