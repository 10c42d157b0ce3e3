// Writes small valid files to begin fuzzing with: write_corpus FOLDER makes FOLDER/READER/FILE.
#include <cstdio>
#include <filesystem>

#include "relief/io/mesh_io.h"
#include "relief/io/project_io.h"
#include "scan/io/clouds/files/ptx_file.h"
#include "scan/io/e57/e57_file.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/grids/pcd_grid_writer.h"
#include "scan/io/grids/ply_grid_writer.h"
#include "scan/io/images/image_io.h"
#include "tests/support/synthetic_views.h"

namespace {

namespace fs = std::filesystem;
using namespace relief;

fs::path file_of(const fs::path& corpus, const char* reader, const char* name) {
  fs::create_directories(corpus / reader);
  return corpus / reader / name;
}

void write_scans(const fs::path& corpus, const RangeView& view) {
  (void)write_file(file_of(corpus, "ply_grid", "scan.ply"), encode_ply_grid(view));
  (void)write_file(file_of(corpus, "pcd", "scan.pcd"), encode_pcd_grid(view));
  (void)write_ptx({view, view}, file_of(corpus, "ptx", "scan.ptx"));
  (void)write_e57({view, view}, file_of(corpus, "e57", "scan.e57"));
  std::string text;
  for (int v = 0; v < view.height(); ++v)
    for (int u = 0; u < view.width(); ++u)
      if (view.has_sample(u, v)) {
        const Eigen::Vector3d p = view.point(u, v);
        for (const double value : p) text += std::to_string(value) + " ";
        text += "0 0 1\n";
      }
  (void)write_file(file_of(corpus, "xyz", "scan.xyz"), text);
  (void)write_file(file_of(corpus, "pts", "scan.pts"), "2\n1 2 3 -5 10 20 30\n2 3 4 -6 10 20 30\n");
}

void write_meshes(const fs::path& corpus, const TriangleMesh& mesh) {
  (void)write_mesh(mesh, file_of(corpus, "ply_mesh", "mesh.ply"));
  (void)write_mesh(mesh, file_of(corpus, "obj", "mesh.obj"));
  (void)write_mesh(mesh, file_of(corpus, "stl", "mesh.stl"));
  (void)write_mesh(mesh, file_of(corpus, "vtp", "mesh.vtp"));
}

void write_images(const fs::path& corpus) {
  Image real(5, 4, 1), whole(5, 4, 3, 255.0);
  for (std::size_t i = 0; i < real.samples.size(); ++i) real.samples[i] = 0.5f + 0.1f * i;
  for (std::size_t i = 0; i < whole.samples.size(); ++i) whole.samples[i] = float(i);
  if (const auto bytes = encode_tiff(real))
    (void)write_file(file_of(corpus, "tiff", "real.tiff"), *bytes);
  if (const auto bytes = encode_png(whole))
    (void)write_file(file_of(corpus, "png", "whole.png"), *bytes);
  const std::string raw(5 * 4 * 4, 'A');
  (void)write_file(file_of(corpus, "pfm", "a.pfm"), "Pf\n5 4\n-1\n" + raw);
  (void)write_file(file_of(corpus, "colmap_array", "a.bin"), "5&4&1&" + raw);
  (void)write_file(file_of(corpus, "raw", "a.raw"), raw);
  (void)write_file(file_of(corpus, "hdr", "a.hdr"),
                   "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 5\n" + raw);
  const std::string tga_head("\0\0\3\0\0\0\0\0\0\0\0\0\5\0\4\0\10\0", 18);
  (void)write_file(file_of(corpus, "tga", "a.tga"), tga_head + raw);
  const std::string bmp_head("BM\x86\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\5\0\0\0\4\0\0\0\1\0\x20\0",
                             30);
  (void)write_file(file_of(corpus, "bmp", "a.bmp"), bmp_head + std::string(24, '\0') + raw);
  const std::string array = "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 5)}";
  const std::string npy_head("\x93NUMPY\1\0\x39\0", 10);
  (void)write_file(file_of(corpus, "npy", "a.npy"), npy_head + array + raw);
}

void write_projects(const fs::path& corpus, const RangeView& view) {
  const fs::path folder = corpus / "scan_json";
  fs::create_directories(folder);
  (void)write_project({view, view}, "mm", folder);
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() != ".json") fs::remove(entry.path());
  (void)write_file(file_of(corpus, "conf", "a.conf"), "bmesh a.ply 0 0 1 0 0 0 1\n");
  (void)write_file(file_of(corpus, "aln", "a.aln"),
                   "1\na.ply\n#\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n0\n");
  (void)write_file(file_of(corpus, "mlp", "a.mlp"),
                   "<!DOCTYPE MeshLabDocument>\n<MeshLabProject><MeshGroup><MLMesh label=\"a\" "
                   "filename=\"a.ply\"><MLMatrix44>1 0 0 0 \n0 1 0 0 \n0 0 1 0 \n0 0 0 1 \n"
                   "</MLMatrix44></MLMesh></MeshGroup></MeshLabProject>\n");
  (void)write_file(file_of(corpus, "poses", "a.json"),
                   "{\"views\":[{\"name\":\"a\",\"world_from_view\":[[1,0,0,0],[0,1,0,0],[0,0,1,0],"
                   "[0,0,0,1]]}]}\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: write_corpus FOLDER\n", stderr);
    return 2;
  }
  RangeView view = relief::testing::render(relief::testing::sphere({0, 0, 10}, 2.0),
                                           Camera::pinhole(9, 7, {16, 16, 4, 3}));
  view.name = "a";
  view.pose = PoseKind::kGuess;
  view.world_from_view.translation() = Eigen::Vector3d(1, 2, 3);
  const fs::path corpus = argv[1];
  write_scans(corpus, view);
  write_meshes(corpus, mesh_from_view(view));
  write_images(corpus);
  write_projects(corpus, view);
}
