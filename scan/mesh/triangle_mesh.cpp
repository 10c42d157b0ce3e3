#include "relief/scan/triangle_mesh.h"

#include <cassert>

#include <Eigen/Geometry>

#include "relief/scan/discontinuities.h"
#include "scan/base/memory/paged_array.h"
#include "scan/base/memory/paged_fill.h"
#include "scan/base/parallel.h"

namespace relief {

Eigen::AlignedBox3d bounding_box(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  serial_for(mesh.vertices.size(), [&](std::size_t v) { box.extend(mesh.vertices[v]); });
  return box;
}

Eigen::Vector3d face_cross(const TriangleMesh& mesh, std::size_t face) {
  const Eigen::Vector3d a = mesh.corner(face, 0);
  return (mesh.corner(face, 1) - a).cross(mesh.corner(face, 2) - a);
}

double surface_area(const TriangleMesh& mesh) {
  double area = 0.0;
  serial_for(mesh.faces.size(), [&](std::size_t f) { area += 0.5 * face_cross(mesh, f).norm(); });
  return area;
}

double enclosed_volume(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0.0;
  // Relative to a vertex, so that nothing is lost far from the origin.
  const Eigen::Vector3d origin = mesh.vertices.front();
  double volume = 0.0;
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    volume += (mesh.corner(f, 0) - origin).dot(face_cross(mesh, f)) / 6.0;
  });
  return volume;
}

PagedVector<Eigen::Vector3f> vertex_normals(const TriangleMesh& mesh) {
  PagedArray<Eigen::Vector3d> sums(mesh.vertices.size());
  serial_for(mesh.faces.size(), [&](std::size_t f) {
    const Eigen::Vector3d cross = face_cross(mesh, f);
    for (const std::uint32_t vertex : mesh.faces[f]) sums[vertex] += cross;
  });
  constexpr std::size_t kGrain = 4096;  // Vertices of one piece of work; changes no result.
  auto normals = paged_filled<Eigen::Vector3f>(sums.size(), Eigen::Vector3f::Zero());
  parallel_for(normals.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) normals[v] = sums[v].stableNormalized().cast<float>();
  });
  return normals;
}

namespace {

constexpr std::uint32_t kNoVertex = 0xffffffffu;

// Splits the connected quad with corners a b / c d (rows) into two triangles, or takes the one
// triangle that its connected edges span.
void triangulate_cell(const GridEdges& edges, const Grid<std::uint32_t>& vertex, int u, int v,
                      bool flip, PagedVector<TriangleMesh::Face>& faces) {
  const std::uint32_t a = vertex(u, v), b = vertex(u + 1, v);
  const std::uint32_t c = vertex(u, v + 1), d = vertex(u + 1, v + 1);
  const bool top = edges.right(u, v), bottom = edges.right(u, v + 1);
  const bool left = edges.down(u, v), right = edges.down(u + 1, v);
  const auto add = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    faces.push_back(flip ? TriangleMesh::Face{i, k, j} : TriangleMesh::Face{i, j, k});
  };
  const int connected = int{top} + int{bottom} + int{left} + int{right};
  if (connected >= 3) {
    add(a, b, d);
    add(a, d, c);
  } else if (connected == 2) {
    if (top && left) add(a, b, c);
    if (top && right) add(a, b, d);
    if (bottom && left) add(a, d, c);
    if (bottom && right) add(b, d, c);
  }
}

}  // namespace

TriangleMesh mesh_from_view(const RangeView& view) {
  const GridEdges edges = connect_samples(view);
  TriangleMesh mesh;
  Grid<std::uint32_t> vertex(view.width(), view.height(), kNoVertex);
  const Eigen::Matrix3d rotation = view.world_from_view.linear();
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      vertex(u, v) = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(view.world_from_view * view.point(u, v));
      if (view.has_normals())
        mesh.normals.push_back((rotation * view.normals(u, v).cast<double>()).cast<float>());
      if (!view.colours.empty()) mesh.colours.push_back(view.colours(u, v));
    }
  }
  for (int v = 0; v + 1 < view.height(); ++v) {
    for (int u = 0; u + 1 < view.width(); ++u) {
      const Ray here = view.camera.ray(u, v);
      const double t = view.has_sample(u, v) ? view.range(u, v) : 1.0;
      const Eigen::Vector3d along_u = view.camera.ray(u + 1, v).at(t) - here.at(t);
      const Eigen::Vector3d along_v = view.camera.ray(u, v + 1).at(t) - here.at(t);
      const bool flip = along_u.cross(along_v).dot(here.direction) > 0.0;
      triangulate_cell(edges, vertex, u, v, flip, mesh.faces);
    }
  }
  return mesh;
}

}  // namespace relief
