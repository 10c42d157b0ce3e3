#include "relief/fusion/tile_mesh.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "fusion/mesh/decimation/edge_collapse.h"
#include "fusion/mesh/decimation/face_octree.h"
#include "scan/base/parallel.h"

namespace relief::fusion {

namespace {

using Face = TriangleMesh::Face;
using Faces = PagedVector<Face>;

constexpr std::size_t kLeastFaces = 100;  // Below, tiles are mostly border.
constexpr std::size_t kFewer = 4;         // Edges twice as long a level.

// The vertices of some faces, in ascending order.
std::vector<std::uint32_t> vertices_of(const Faces& faces) {
  std::vector<std::uint32_t> vertices;
  vertices.reserve(3 * faces.size());
  for (const Face& face : faces) vertices.insert(vertices.end(), face.begin(), face.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

template <typename Values>
void take_values(const Values& from, const std::vector<std::uint32_t>& vertices, Values& to) {
  if (from.empty()) return;
  to.reserve(vertices.size());
  for (const std::uint32_t v : vertices) to.push_back(from[v]);
}

// Faces of a mesh, with only their vertices.
struct MeshPart {
  std::vector<std::uint32_t> vertices;  // Of the whole mesh, for each of the part.
  TriangleMesh mesh;
};

MeshPart part_with_places(const TriangleMesh& mesh, const Faces& faces) {
  MeshPart part;
  part.vertices = vertices_of(faces);
  take_values(mesh.vertices, part.vertices, part.mesh.vertices);
  part.mesh.faces = faces;
  for (Face& face : part.mesh.faces)
    for (std::uint32_t& v : face)
      v = static_cast<std::uint32_t>(
          std::lower_bound(part.vertices.begin(), part.vertices.end(), v) - part.vertices.begin());
  return part;
}

TriangleMesh part_with_attributes(const TriangleMesh& mesh, const Faces& faces) {
  MeshPart part = part_with_places(mesh, faces);
  take_values(mesh.normals, part.vertices, part.mesh.normals);
  take_values(mesh.quality, part.vertices, part.mesh.quality);
  take_values(mesh.views, part.vertices, part.mesh.views);
  take_values(mesh.source_views, part.vertices, part.mesh.source_views);
  take_values(mesh.filled, part.vertices, part.mesh.filled);
  take_values(mesh.colours, part.vertices, part.mesh.colours);
  return std::move(part.mesh);
}

// Edges of only one face. Each keeps a face.
std::size_t border_edges(const TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(3 * mesh.faces.size());
  for (const Face& face : mesh.faces)
    for (std::size_t k = 0; k < 3; ++k) edges.push_back(std::minmax(face[k], face[(k + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  std::size_t single = 0;
  for (auto edge = edges.begin(); edge != edges.end();) {
    const auto next = std::find_if(edge, edges.end(), [&](const auto& e) { return e != *edge; });
    if (next - edge == 1) ++single;
    edge = next;
  }
  return single;
}

// The same surface with fewer faces, all of whose vertices are vertices of `mesh`: a quarter, but
// no more than `most` beside those of the border.
Faces fewer_faces(const TriangleMesh& mesh, const Faces& faces, std::size_t most) {
  MeshPart part = part_with_places(mesh, faces);
  const std::size_t border = border_edges(part.mesh);
  const std::size_t wanted = border + std::min(most, (faces.size() - border) / kFewer);
  collapse_edges(part.mesh,
                 {.faces = wanted, .max_error = std::numeric_limits<double>::infinity()});
  for (Face& face : part.mesh.faces)
    for (std::uint32_t& v : face) v = part.vertices[v];
  return std::move(part.mesh.faces);
}

// Over the surface: the short edges along a border count little.
double mean_edge_length(const TriangleMesh& mesh) {
  double sum = 0.0, area = 0.0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    double around = 0.0;
    for (int k = 0; k < 3; ++k) around += (mesh.corner(f, k) - mesh.corner(f, (k + 1) % 3)).norm();
    const double twice_the_area = face_cross(mesh, f).norm();
    sum += twice_the_area * around / 3.0;
    area += twice_the_area;
  }
  return area > 0.0 ? sum / area : 0.0;
}

class Tiler {
 public:
  Tiler(const TriangleMesh& mesh, const TileOptions& options, const StoreTile& store)
      : mesh_(mesh),
        options_(options),
        store_(store),
        octree_(divide_faces(mesh, options.faces)),
        tiles_(octree_.cubes.size()),
        faces_(octree_.cubes.size()) {}

  // The deepest tiles first: a tile is made of those below it.
  Result<std::vector<MeshTile>> run(const Progress& progress) {
    for (std::size_t end = tiles_.size(); end > 0;) {
      std::size_t begin = end - std::min(end, kTilesAtOnce);
      while (octree_.cubes[begin].depth < octree_.cubes[end - 1].depth) ++begin;
      if (auto made = make(begin, end); !made) return made.error();
      end = begin;
      if (!report_progress(progress, 1.0 - static_cast<double>(end) / tiles_.size(), "tiles"))
        return Error{ErrorKind::kInterrupted, "cutting the mesh into tiles was stopped"};
    }
    return std::move(tiles_);
  }

 private:
  static constexpr std::size_t kTilesAtOnce = 64;  // Between reports. Changes no result.

  Result<void> make(std::size_t begin, std::size_t end) {
    std::vector<std::optional<Error>> errors(end - begin);
    parallel_for(end - begin, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i)
        if (auto made = make(begin + i); !made) errors[i] = made.error();
    });
    for (auto& error : errors)
      if (error) return std::move(*error);
    return {};
  }

  Result<void> make(std::size_t i) {
    faces_[i] = faces_of(octree_.cubes[i]);
    const TriangleMesh part = part_with_attributes(mesh_, faces_[i]);
    MeshTile& tile = tiles_[i];
    tile.children = octree_.cubes[i].children;
    tile.faces = part.faces.size();
    tile.edge_length = mean_edge_length(part);
    tile.box = bounding_box(part);
    for (const std::size_t child : tile.children) tile.box.extend(tiles_[child].box);
    return store_(i, part);
  }

  // Those of the mesh, or fewer than the parts have, whose faces are needed no more then.
  Faces faces_of(const FaceCube& cube) {
    Faces faces;
    if (cube.children.empty()) {
      for (std::size_t i = cube.begin; i < cube.end; ++i)
        faces.push_back(mesh_.faces[octree_.faces[i]]);
      return faces;
    }
    for (const std::size_t child : cube.children) {
      faces.insert(faces.end(), faces_[child].begin(), faces_[child].end());
      Faces().swap(faces_[child]);
    }
    return fewer_faces(mesh_, faces, options_.faces);
  }

  const TriangleMesh& mesh_;
  TileOptions options_;
  const StoreTile& store_;
  FaceOctree octree_;
  std::vector<MeshTile> tiles_;
  std::vector<Faces> faces_;  // Of each tile whose parent is not made yet, as in the whole mesh.
};

}  // namespace

Result<std::vector<MeshTile>> tile_mesh(const TriangleMesh& mesh, const TileOptions& options,
                                        const StoreTile& store, const Context& context) {
  if (mesh.faces.empty())
    return Error{ErrorKind::kBadInput, "a mesh without faces cannot be cut into tiles"};
  if (options.faces < kLeastFaces)
    return Error{ErrorKind::kBadInput, "tiles need at least 100 faces each"};
  return run_in(context, [&] { return Tiler(mesh, options, store).run(context.progress); });
}

}  // namespace relief::fusion
