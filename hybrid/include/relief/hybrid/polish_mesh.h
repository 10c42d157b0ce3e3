#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "relief/hybrid/mesh_normals.h"
#include "relief/scan/context.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::hybrid {

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
