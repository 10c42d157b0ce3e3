// Every reader on damaged files: each prefix and many random changes of a valid file must give an
// error or a value, never a crash, a hang or a huge allocation.
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "relief/io/mesh_io.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/files/ply_file.h"
#include "scan/io/grids/grid_file.h"
#include "scan/io/grids/ply_grid_writer.h"
#include "scan/io/images/image_io.h"
#include "scan/io/meshes/mesh_codecs.h"
#include "scan/io/project/view_spec.h"
#include "tests/support/limited_memory.h"
#include "tests/support/result_matchers.h"
#include "tests/support/scenes/synthetic_views.h"
#include "tests/support/temporary_folder.h"

namespace relief {
namespace {

using testing::LimitedMemory;
using testing::TemporaryFolder;

using Reader = std::function<bool(const std::string& content)>;

// Cuts everywhere in the first 300 bytes, then at `cuts` places.
void try_prefixes(const std::string& content, const Reader& read, std::size_t cuts) {
  for (std::size_t size = 0; size < std::min<std::size_t>(300, content.size()); ++size)
    read(content.substr(0, size));
  for (std::size_t k = 0; k < cuts; ++k) read(content.substr(0, k * content.size() / cuts));
}

void try_changes(const std::string& content, const Reader& read, int tries) {
  std::mt19937 random(7);
  for (int k = 0; k < tries; ++k) {
    std::string changed = content;
    const std::size_t changes = 1 + random() % 4;
    for (std::size_t i = 0; i < changes; ++i) {
      // Half of the changes go where headers are.
      const std::size_t range =
          random() % 2 ? changed.size() : std::min<std::size_t>(400, changed.size());
      changed[random() % range] =
          static_cast<char>(random() % 3 ? random() % 256 : '0' + random() % 10);
    }
    read(changed);
  }
}

RangeView small_view() {
  const Camera camera = Camera::pinhole(12, 9, {20, 20, 5.5, 4});
  return testing::render(testing::sphere({0, 0, 10}, 2.0), camera);
}

std::string ascii_grid() {
  std::string text =
      "ply\nformat ascii 1.0\nobj_info num_cols 3\nobj_info num_rows 2\nelement vertex 4\n"
      "property float x\nproperty float y\nproperty float z\nelement range_grid 6\n"
      "property list uchar int vertex_indices\nend_header\n";
  text += "0 0 1.5\n1 0 1.25\n-1e-3 1 1\n2 1 0.5\n1 0\n1 1\n0\n1 2\n0\n1 3\n";
  return text;
}

TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  mesh.normals = vertex_normals(mesh);
  mesh.quality = {1, 2, 3, 4};
  return mesh;
}

TEST(DamagedFiles, AsciiPly) {
  const Reader read = [](const std::string& content) { return parse_ply(content, "a.ply").ok(); };
  ASSERT_TRUE(read(ascii_grid()));
  // Only a cut inside the last number or line end can go unnoticed.
  for (std::size_t size = 0; size + 2 < ascii_grid().size(); ++size)
    EXPECT_FALSE(read(ascii_grid().substr(0, size))) << size;
  try_changes(ascii_grid(), read, 20000);
}

TEST(DamagedFiles, BinaryPly) {
  const std::string content = encode_ply_grid(small_view());
  const Reader read = [](const std::string& c) { return parse_ply(c, "a.ply").ok(); };
  ASSERT_TRUE(read(content));
  for (std::size_t size = 0; size < content.size(); ++size)
    EXPECT_FALSE(read(content.substr(0, size))) << size;
  try_changes(content, read, 20000);
}

// Readers that take paths: through a file.
Reader through_file(const TemporaryFolder& folder, const std::string& name,
                    const std::function<bool(const std::filesystem::path&)>& read) {
  return [&folder, name, read](const std::string& content) {
    return read(folder.write(name, content));
  };
}

TEST(DamagedFiles, GridsAndMeshes) {
  const TemporaryFolder folder;
  const Reader grid =
      through_file(folder, "g.ply", [](const auto& p) { return read_grid_file(p).ok(); });
  const Reader ply = through_file(folder, "m.ply", [](const auto& p) { return read_mesh(p).ok(); });
  ASSERT_TRUE(grid(ascii_grid()));
  try_changes(ascii_grid(), grid, 3000);
  ASSERT_THAT(write_mesh(tetrahedron(), folder / "whole.ply"), IsOk());
  const std::string mesh = value_of(read_file(folder / "whole.ply"));
  ASSERT_TRUE(ply(mesh));
  try_prefixes(mesh, ply, 50);
  try_changes(mesh, ply, 3000);
}

TEST(DamagedFiles, ObjAndStl) {
  const TemporaryFolder folder;
  for (const bool is_obj : {true, false}) {
    const std::string content =
        is_obj ? *encode_obj_mesh(tetrahedron()) : *encode_stl_mesh(tetrahedron());
    const Reader read = through_file(folder, is_obj ? "a.obj" : "a.stl",
                                     [](const auto& p) { return read_mesh(p).ok(); });
    ASSERT_TRUE(read(content));
    try_prefixes(content, read, 50);
    try_changes(content, read, 1500);
  }
}

TEST(DamagedFiles, Vtp) {
  const TemporaryFolder folder;
  const std::string content = *encode_vtp_mesh(tetrahedron());
  const Reader read =
      through_file(folder, "a.vtp", [](const auto& p) { return read_mesh(p).ok(); });
  ASSERT_TRUE(read(content));
  const LimitedMemory limit(std::size_t{1} << 30);
  // Only the closing tags can go unnoticed.
  for (std::size_t size = 0; size + 40 < content.size(); ++size)
    EXPECT_FALSE(read(content.substr(0, size))) << size;
  try_changes(content, read, 10000);
}

TEST(DamagedFiles, Images) {
  Image depth(33, 17, 1, 65535);
  Image normals(33, 17, 3);
  for (std::size_t i = 0; i < depth.samples.size(); ++i)
    depth.samples[i] = static_cast<float>(i * 37 % 65536);
  for (std::size_t i = 0; i < normals.samples.size(); ++i)
    normals.samples[i] = static_cast<float>(i) * 0.37f;
  const Reader png = [](const std::string& c) { return decode_png(c, "a.png").ok(); };
  const Reader tiff = [](const std::string& c) { return decode_tiff(c, "a.tiff").ok(); };
  ASSERT_TRUE(png(*encode_png(depth)));
  try_prefixes(*encode_png(depth), png, 100);
  try_changes(*encode_png(depth), png, 3000);
  ASSERT_TRUE(tiff(*encode_tiff(normals)));
  try_prefixes(*encode_tiff(normals), tiff, 100);
  try_changes(*encode_tiff(normals), tiff, 3000);
}

TEST(DamagedFiles, TruncatedImagesAreErrors) {
  Image depth(64, 48, 1, 65535);
  for (std::size_t i = 0; i < depth.samples.size(); ++i)
    depth.samples[i] = static_cast<float>(i * 7919 % 65536);
  const std::string png = *encode_png(depth), tiff = *encode_tiff(Image(64, 48, 1));
  for (std::size_t k = 0; k < 50; ++k) {
    EXPECT_THAT(decode_png(std::string_view(png).substr(0, k * png.size() / 50), "a"), HasError());
    EXPECT_THAT(decode_tiff(std::string_view(tiff).substr(0, k * tiff.size() / 50), "a"),
                HasError());
  }
}

TEST(DamagedFiles, ScanJson) {
  const std::string text = R"({"format":"relief-scan","version":1,"unit":"mm","views":[
    {"name":"a","depth":{"file":"a.png","scale":0.5,"kind":"ray"},
     "camera":{"model":"pinhole","width":6,"height":4,"fx":9,"fy":9,"cx":3,"cy":2},
     "world_from_view":[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]],"pose_is":"known"},
    {"name":"b","grid":{"file":"b.ply"},
     "camera":{"model":"orthographic","view_direction":[0,0,-1]}}]})";
  const Reader read = [](const std::string& c) { return parse_scan_json(c, "scan.json").ok(); };
  ASSERT_TRUE(read(text));
  for (std::size_t size = 0; size < text.size(); ++size) EXPECT_FALSE(read(text.substr(0, size)));
  try_changes(text, read, 20000);
  EXPECT_FALSE(read(std::string(200000, '[')));
}

}  // namespace
}  // namespace relief
