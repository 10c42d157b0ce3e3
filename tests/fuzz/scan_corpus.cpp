// Files of scans and meshes in each form that a reader tells apart.
#include <cstdint>
#include <string>

#include "relief/io/mesh_io.h"
#include "scan/io/clouds/files/ptx_file.h"
#include "scan/io/e57/e57_file.h"
#include "scan/io/files/binary_writer.h"
#include "scan/io/grids/pcd_grid_writer.h"
#include "scan/io/grids/ply_grid_writer.h"
#include "tests/fuzz/corpus_folder.h"
#include "tests/support/scenes/synthetic_views.h"

namespace relief::testing {

namespace {

RangeView small_view() {
  RangeView view = render(sphere({0, 0, 10}, 2.0), Camera::pinhole(9, 7, {16, 16, 4, 3}));
  view.name = "a";
  view.pose = PoseKind::kGuess;
  view.world_from_view.translation() = Eigen::Vector3d(1, 2, 3);
  return view;
}

std::string pcd_header(const std::string& size, const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n" +
         size + "VIEWPOINT 1 2 3 1 0 0 0\nPOINTS 4\nDATA " + data + "\n";
}

// The points of four pixels, field by field, as LZF keeps what it cannot shorten.
std::string compressed_points() {
  std::string fields;
  for (const float value : {0.f, 1.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 5.f, 5.f, 5.f, 6.f})
    append_little_endian(fields, value);
  for (const std::uint32_t colour : {1u, 2u, 3u, 4u}) append_little_endian(fields, colour);
  const std::string packed =
      std::string(1, '\x1f') + fields.substr(0, 32) + std::string(1, '\x1f') + fields.substr(32);
  std::string bytes;
  append_little_endian(bytes, static_cast<std::uint32_t>(packed.size()));
  append_little_endian(bytes, static_cast<std::uint32_t>(fields.size()));
  return bytes + packed;
}

void add_pcd(const CorpusFolder& corpus) {
  const std::string square = "WIDTH 2\nHEIGHT 2\n", row = "WIDTH 4\nHEIGHT 1\n";
  const std::string points = "0 0 5 1\n1 0 5 2\nnan nan nan 3\n1 1 6 4\n";
  corpus.add("pcd", "binary.pcd", encode_pcd_grid(small_view()));
  corpus.add("pcd", "text.pcd", pcd_header(square, "ascii") + points);
  corpus.add("pcd", "row.pcd", pcd_header(row, "ascii") + points);
  corpus.add("pcd", "packed.pcd", pcd_header(square, "binary_compressed") + compressed_points());
}

const char* const kTextGrid =
    "ply\nformat ascii 1.0\nobj_info num_cols 3\nobj_info num_rows 2\nelement vertex 4\n"
    "property float x\nproperty float y\nproperty float z\nproperty uchar red\n"
    "property uchar green\nproperty uchar blue\nelement range_grid 6\n"
    "property list uchar int vertex_indices\nend_header\n0 0 1.5 1 2 3\n1 0 1.25 4 5 6\n"
    "-1e-3 1 1 7 8 9\n2 1 0.5 0 0 0\n1 0\n1 1\n0\n1 2\n0\n1 3\n";

std::string text_of_points(const RangeView& view) {
  std::string text;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u) {
      if (!view.has_sample(u, v)) continue;
      const Eigen::Vector3d p = view.point(u, v);
      for (const double value : p) text += std::to_string(value) + " ";
      text += "0 0 1\n";
    }
  return text;
}

}  // namespace

void add_scans(const CorpusFolder& corpus) {
  const RangeView view = small_view();
  for (const char* target : {"ply_grid", "grid_view"}) {
    corpus.add(target, "binary.ply", encode_ply_grid(view));
    corpus.add(target, "text.ply", kTextGrid);
  }
  add_pcd(corpus);
  (void)write_ptx({view, view}, corpus.path_of("ptx", "two.ptx"));
  (void)write_e57({view, view}, corpus.path_of("e57", "two.e57"));
  corpus.add("xyz", "normals.xyz", text_of_points(view));
  corpus.add("xyz", "named.xyz", "//X,Y,Z,R,G,B\n1,2,3,4,5,6\n2,2,3,4,5,6\n1,3,3,4,5,6\n");
  corpus.add("pts", "a.pts", "2\n1 2 3 -5 10 20 30\n2 3 4 -6 10 20 30\n");
}

void add_meshes(const CorpusFolder& corpus) {
  const TriangleMesh mesh = mesh_from_view(small_view());
  (void)write_mesh(mesh, corpus.path_of("ply_mesh", "mesh.ply"));
  (void)write_mesh(mesh, corpus.path_of("obj", "mesh.obj"));
  (void)write_mesh(mesh, corpus.path_of("stl", "mesh.stl"));
  (void)write_mesh(mesh, corpus.path_of("vtp", "mesh.vtp"));
  corpus.add("obj", "quad.obj",
             "v 0 0 0\nv 1 0 0 1 0 0\nvn 0 0 1\nv 1 1 0\nv 0 1 0\n"
             "f 1/1/1 2//1 3 -1\n");
  corpus.add("stl", "text.stl",
             "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
             "vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n");
}

}  // namespace relief::testing
