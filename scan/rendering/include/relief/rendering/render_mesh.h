#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "relief/rendering/picture.h"
#include "relief/rendering/picture_camera.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"
#include "relief/scan/triangle_mesh.h"

namespace relief::rendering {

/// What a picture shows.
enum class RenderStyle {
  kShaded,         ///< Matte, lit from the front.
  kGrazing,        ///< Matte, lit from the side: shows low relief.
  kAccessibility,  ///< Ambient occlusion: how much of the sky each point sees (Miller 1994).
  kDepth,          ///< The range t of each point along its ray (V1).
  kNormals,        ///< As normal maps: (n + 1) / 2, n right, up and towards the viewer.
  kExpectedError,  ///< `TriangleMesh::quality`; filled vertices are grey.
  kFilled,         ///< `TriangleMesh::filled`.
  kViews,          ///< `TriangleMesh::views`.
  kDistance,       ///< `RenderOptions::distances`.
  kColours,        ///< `TriangleMesh::colours`, without light.
};

/// As on the command line, e.g. `expected_error`.
std::string_view to_string(RenderStyle style);

/// Where the normals of the surface come from.
enum class ShadingNormals {
  kOwn,       ///< The mesh's own; those of its geometry where it has none.
  kGeometry,  ///< Of the vertices, weighted by the areas of their faces.
  kFaces,     ///< Each face is flat.
};

/// Where the light stands, seen from the surface in the middle of the picture: 0, 0 is the viewer,
/// positive azimuths are right, positive elevations above.
struct LightDirection {
  double azimuth_deg = 0.0;
  double elevation_deg = 0.0;
};

struct RenderOptions {
  /// Every pixel has n x n rays, evenly. >= 1. Bounds the time.
  int antialiasing = 2;
  ShadingNormals normals = ShadingNormals::kOwn;
  /// Of kShaded and kGrazing; unset: their own.
  std::optional<LightDirection> light;
  /// Of kAccessibility: random rays of a pixel at least. >= 1. Bounds the time: an open share is
  /// good to sqrt(p (1 - p) / 64), 0.06 at most.
  int ambient_rays = 64;
  /// Of kAccessibility: what is farther away leaves a point open, as a part of the diagonal of the
  /// mesh's bounding box. > 0.
  double ambient_reach = 0.25;
  /// Values at the ends of the colour bar, low < high; unset: from the data. Values beyond have the
  /// colours of the ends.
  std::optional<std::array<double, 2>> range;
  /// Of kDistance: for each vertex its distance to another surface [unit], as of
  /// evaluation::signed_distances.
  std::vector<double> distances;
  std::string unit;  ///< Of lengths, for the legend; may be empty.
  Background background = Background::kWhite;
  std::uint64_t seed = 1;  ///< Of the random rays.
};

struct Rendering {
  Picture picture;
  std::optional<Legend> legend;  ///< Of styles whose colours are values.
};

/// A mesh that is ready for pictures from all sides and in all styles.
class MeshScene {
 public:
  /// kBadInput: a mesh without faces or extent, a vertex that is not finite, or a face with an
  /// index out of range. kUnsolvable: not enough memory.
  static Result<MeshScene> of(TriangleMesh mesh);

  const TriangleMesh& mesh() const;

  /// Casts rays by Embree (Wald et al. 2014) with watertight intersections, so nothing shines
  /// through between two faces. The back of a face is brown where it is lit. kBadInput: the mesh
  /// does not have what the style shows.
  Result<Rendering> render(const PictureCamera& camera, RenderStyle style,
                           const RenderOptions& options = {}) const;

 private:
  struct Parts;
  explicit MeshScene(std::shared_ptr<const Parts> parts) : parts_(std::move(parts)) {}
  std::shared_ptr<const Parts> parts_;
};

/// One picture of a mesh.
Result<Rendering> render_mesh(const TriangleMesh& mesh, const PictureCamera& camera,
                              RenderStyle style, const RenderOptions& options = {});

/// The samples of a view as mesh_from_view makes a mesh of them, with their range standard
/// deviations as `quality` where the view has them.
TriangleMesh surface_of_view(const RangeView& view);

}  // namespace relief::rendering
